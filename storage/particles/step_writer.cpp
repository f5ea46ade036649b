// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/particles/step_writer.h"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

#include "protocol/scene/json.h"
#include "storage/file_descriptor.h"
#include "storage/hash.h"
#include "storage/particles/hdf5_id.h"
#include "storage/particles/step_layout.h"
#include "storage/system_error.h"
#include "storage/write_file.h"

namespace mote::storage {
namespace {

namespace fs = std::filesystem;

/// One array on its way to the file.
struct Piece {
    StepArrayLayout layout;
    std::vector<hsize_t> shape;
    std::span<const std::byte> bytes;
    haddr_t offset = 0;  ///< in the file; 0 for an array without bytes
};

template <class T>
Piece piece(StepArray which, std::vector<hsize_t> shape, std::span<T> values) {
    return {stepArrays[static_cast<std::size_t>(which)], std::move(shape), std::as_bytes(values)};
}

std::vector<Piece> piecesOf(const StepContent& content) {
    const auto& nodes = content.nodes;
    const auto& leaves = content.leaves;
    const hsize_t n = nodes.size();
    const hsize_t l = leaves.size();
    const hsize_t p = content.rows.size();
    const hsize_t d = content.volumeSize;
    const hsize_t q = content.previewPoints.size();
    const hsize_t b = content.previewThreshold.size();
    return {
        piece(StepArray::octreeLevel, {n}, nodes.level),
        piece(StepArray::octreeMorton, {n}, nodes.morton),
        piece(StepArray::octreeFirstChild, {n}, nodes.firstChild),
        piece(StepArray::octreeChildCount, {n}, nodes.childCount),
        piece(StepArray::octreeCount, {n}, nodes.count),
        piece(StepArray::octreeDensity, {n}, nodes.density),
        piece(StepArray::octreeMinDensity, {n}, nodes.minDensity),
        piece(StepArray::leafNode, {l}, leaves.node),
        piece(StepArray::leafPointBegin, {l}, leaves.pointBegin),
        piece(StepArray::leafPointCount, {l}, leaves.pointCount),
        piece(StepArray::leafDensity, {l}, leaves.density),
        piece(StepArray::pointPosition, {p, 3}, content.positions),
        piece(StepArray::pointRow, {p}, content.rows),
        piece(StepArray::volumeDensity, {d, d, d}, content.volume),
        piece(StepArray::previewPoint, {q, 4}, content.previewPoints),
        piece(StepArray::previewThreshold, {b}, content.previewThreshold),
    };
}

hid_t fileType(std::string_view type) {
    if (type == "u8") return H5T_STD_U8LE;
    if (type == "u16") return H5T_STD_U16LE;
    if (type == "u32") return H5T_STD_U32LE;
    if (type == "u64") return H5T_STD_U64LE;
    return H5T_IEEE_F32LE;
}

/// Writes nothing but what describes the file: superblock, groups, arrays (allocated, not filled) and
/// attributes. Every call returns whether it went well; the first failure ends the rest.
class Layout {
  public:
    explicit Layout(const fs::path& path)
        : access_(H5Pcreate(H5P_FILE_ACCESS), H5Pclose),
          creation_(H5Pcreate(H5P_FILE_CREATE), H5Pclose),
          file_(create(path), H5Fclose) {}

    bool write(const StepContent& content, std::vector<Piece>& pieces) {
        if (!file_.valid() || !addGroups()) return false;
        for (auto& one : pieces) {
            if (!addArray(one)) return false;
        }
        return addAttributes(content) && file_.close();
    }

  private:
    hid_t create(const fs::path& path) {
        // Arrays begin at multiples of 64, so that a mapping can be used as numbers of any size. Times would
        // make the same content give other bytes.
        const bool set = H5Pset_libver_bounds(access_.get(), H5F_LIBVER_LATEST, H5F_LIBVER_LATEST) >= 0 &&
                         H5Pset_alignment(access_.get(), 1, 64) >= 0 &&
                         H5Pset_file_locking(access_.get(), false, true) >= 0 &&
                         H5Pset_obj_track_times(creation_.get(), false) >= 0;
        return set ? H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation_.get(), access_.get()) : -1;
    }

    bool addGroups() {
        const Hdf5Id properties(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
        if (H5Pset_obj_track_times(properties.get(), false) < 0) return false;
        return std::all_of(stepGroups.begin(), stepGroups.end(), [&](const char* name) {
            return Hdf5Id(H5Gcreate2(file_.get(), name, H5P_DEFAULT, properties.get(), H5P_DEFAULT), H5Gclose)
                .valid();
        });
    }

    bool addArray(Piece& one) {
        const Hdf5Id properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
        const Hdf5Id space(H5Screate_simple(static_cast<int>(one.shape.size()), one.shape.data(), nullptr),
                           H5Sclose);
        if (H5Pset_layout(properties.get(), H5D_CONTIGUOUS) < 0 ||
            H5Pset_alloc_time(properties.get(), H5D_ALLOC_TIME_EARLY) < 0 ||
            H5Pset_fill_time(properties.get(), H5D_FILL_TIME_NEVER) < 0 ||
            H5Pset_obj_track_times(properties.get(), false) < 0 || !space.valid()) {
            return false;
        }
        const Hdf5Id dataset(H5Dcreate2(file_.get(), one.layout.name, fileType(one.layout.type), space.get(),
                                        H5P_DEFAULT, properties.get(), H5P_DEFAULT),
                             H5Dclose);
        if (!dataset.valid()) return false;
        if (one.bytes.empty()) return true;
        one.offset = H5Dget_offset(dataset.get());
        return one.offset != HADDR_UNDEF;
    }

    bool addAttribute(const char* name, hid_t stored, hid_t native, const std::vector<hsize_t>& shape,
                      const void* values) {
        const Hdf5Id space(shape.empty()
                               ? H5Screate(H5S_SCALAR)
                               : H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr),
                           H5Sclose);
        const Hdf5Id attribute(H5Acreate2(file_.get(), name, stored, space.get(), H5P_DEFAULT, H5P_DEFAULT),
                               H5Aclose);
        return attribute.valid() && H5Awrite(attribute.get(), native, values) >= 0;
    }

    bool addAttributes(const StepContent& content) {
        constexpr std::size_t width = 16;  // of an axis' name, padded with zeros
        const Hdf5Id text(H5Tcopy(H5T_C_S1), H5Tclose);
        std::array<char, 3 * width> names{};
        for (std::size_t i = 0; i < 3; ++i) content.axes[i].copy(&names[i * width], width);
        return H5Tset_size(text.get(), width) >= 0 && H5Tset_strpad(text.get(), H5T_STR_NULLPAD) >= 0 &&
               addAttribute("axes", text.get(), text.get(), {3}, names.data()) &&
               addAttribute("bounds_min", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, {3}, content.boundsMin.data()) &&
               addAttribute("bounds_max", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, {3}, content.boundsMax.data()) &&
               addAttribute("total_weight", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, {}, &content.totalWeight);
    }

    Hdf5Id access_;
    Hdf5Id creation_;
    Hdf5Id file_;
};

/// Makes the file with room for everything, before HDF5 sees it.
Status reserve(const fs::path& path, const std::vector<Piece>& pieces) {
    std::uint64_t size = 16384;
    for (const auto& one : pieces) size += one.bytes.size() + 64;
    const FileDescriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (!file.valid()) return systemError(errno, path.string(), "cannot be made");
    int number = 0;
    do {
        number = ::fallocate(file.get(), 0, 0, static_cast<off_t>(size)) == 0 ? 0 : errno;
    } while (number == EINTR);
    if (number == 0 || number == EOPNOTSUPP || number == ENOSYS) return success();
    return systemError(number, path.string(), fmt::format("cannot have the {} bytes that it needs", size));
}

Status writePieces(const fs::path& path, const std::vector<Piece>& pieces) {
    const FileDescriptor file(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
    if (!file.valid()) return systemError(errno, path.string(), "cannot be opened");
    for (const auto& one : pieces) MOTE_RETURN_IF_ERROR(writeAt(file.get(), one.offset, one.bytes, path));
    return success();
}

proto::Digest digestOf(const std::vector<Piece>& pieces) {
    proto::Digest digest;
    for (const auto& one : pieces) {
        auto& array = *digest.add_arrays();
        array.set_name(one.layout.name);
        array.set_type(std::string(one.layout.type));
        for (const auto extent : one.shape) array.add_shape(extent);
        array.set_offset(one.offset);
        for (const auto hash : hashBlocks(one.bytes)) array.add_blocks(hash);
    }
    return digest;
}

}  // namespace

Status writeStep(const fs::path& directory, const std::string& name, const StepContent& content) {
    // Its errors become ours; nothing of them is for the terminal.
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    const auto path = directory / (name + ".h5");
    auto pieces = piecesOf(content);
    MOTE_RETURN_IF_ERROR(reserve(path, pieces));
    if (!Layout(path).write(content, pieces)) {
        return Error{ErrorCode::internal, path.string(), "HDF5 cannot lay the file out"};
    }
    MOTE_RETURN_IF_ERROR(writePieces(path, pieces));
    return writeNewFile(directory / (name + ".digest"), toJson(digestOf(pieces)));
}

std::string stepName(std::uint32_t step) {
    return fmt::format("step-{:06}", step);
}

}  // namespace mote::storage
