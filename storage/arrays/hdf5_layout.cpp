// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/arrays/hdf5_layout.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <hdf5.h>
#include <sys/resource.h>
#include <sys/vfs.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "protocol/base/system_error.h"
#include "storage/files/dataset_file.h"
#include "storage/files/file_descriptor.h"

namespace mote::storage {
namespace {

/// An identifier of the HDF5 library with the call that closes it. Move-only; one thread.
class Hdf5Id {
  public:
    using Close = herr_t (*)(hid_t);

    Hdf5Id(hid_t id, Close closing) : id_(id), close_(closing) {}
    Hdf5Id(Hdf5Id&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
    Hdf5Id& operator=(Hdf5Id&&) = delete;
    ~Hdf5Id() {
        if (id_ >= 0) close_(id_);
    }

    hid_t get() const { return id_; }
    bool valid() const { return id_ >= 0; }
    /// Closes now; whether that went well.
    bool close() { return close_(std::exchange(id_, -1)) >= 0; }

  private:
    hid_t id_;
    Close close_;
};

/// Errors as those of fallocate(), of a file in memory alone: there each page would be made and given back.
int checkRoomInMemory(int descriptor, std::uint64_t size) {
    struct statfs status {};
    if (::fstatfs(descriptor, &status) != 0) return errno;
    rlimit limit{};
    if (::getrlimit(RLIMIT_FSIZE, &limit) == 0 && size > limit.rlim_cur) return EFBIG;
    // Without blocks there is no limit.
    const bool limited = status.f_blocks > 0;
    return limited && size / static_cast<std::uint64_t>(status.f_bsize) >= status.f_bavail ? ENOSPC : 0;
}

/// Makes the file, if there is room for everything, before HDF5 sees it and makes it empty again.
Status reserve(const std::filesystem::path& path, const FileLayout& layout) {
    std::uint64_t size = 16384;
    for (const auto& array : layout.arrays) size += bytesOf(array) + 64;
    const FileDescriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (!file.valid()) return systemError(errno, path.string(), "cannot be made");
    int number = 0;
    do {
        if (isInMemory(file.get()))
            number = checkRoomInMemory(file.get(), size);
        else
            number = ::fallocate(file.get(), 0, 0, static_cast<off_t>(size)) == 0 ? 0 : errno;
    } while (number == EINTR);
    if (number == 0 || number == EOPNOTSUPP || number == ENOSYS) return success();
    return systemError(number, path.string(), fmt::format("cannot have the {} bytes that it needs", size));
}

hid_t fileType(std::string_view type) {
    if (type == "u8") return H5T_STD_U8LE;
    if (type == "u16") return H5T_STD_U16LE;
    if (type == "u32") return H5T_STD_U32LE;
    if (type == "u64") return H5T_STD_U64LE;
    if (type == "f64") return H5T_IEEE_F64LE;
    return H5T_IEEE_F32LE;
}

/// Every call returns whether it went well; the first failure ends the rest.
class Layout {
  public:
    explicit Layout(const std::filesystem::path& path)
        : access_(H5Pcreate(H5P_FILE_ACCESS), H5Pclose),
          creation_(H5Pcreate(H5P_FILE_CREATE), H5Pclose),
          file_(create(path), H5Fclose) {}

    bool write(const FileLayout& layout, std::vector<ArrayPlace>& places) {
        if (!file_.valid() || !addGroups(layout.groups)) return false;
        for (const auto& array : layout.arrays) {
            if (!addArray(array, places.emplace_back())) return false;
        }
        for (const auto& attribute : layout.attributes) {
            if (!std::visit([&](const auto& value) { return addAttribute(attribute.name, value); },
                            attribute.value)) {
                return false;
            }
        }
        return file_.close();
    }

  private:
    hid_t create(const std::filesystem::path& path) {
        // Arrays begin at multiples of 64, so that a mapping can be used as numbers of any size. Times would
        // make the same content give other bytes.
        const bool set = H5Pset_libver_bounds(access_.get(), H5F_LIBVER_LATEST, H5F_LIBVER_LATEST) >= 0 &&
                         H5Pset_alignment(access_.get(), 1, 64) >= 0 &&
                         H5Pset_file_locking(access_.get(), false, true) >= 0 &&
                         H5Pset_obj_track_times(creation_.get(), false) >= 0;
        return set ? H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation_.get(), access_.get()) : -1;
    }

    bool addGroups(const std::vector<std::string>& groups) {
        const Hdf5Id properties(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
        if (H5Pset_obj_track_times(properties.get(), false) < 0) return false;
        return std::all_of(groups.begin(), groups.end(), [&](const std::string& name) {
            return Hdf5Id(H5Gcreate2(file_.get(), name.c_str(), H5P_DEFAULT, properties.get(), H5P_DEFAULT),
                          H5Gclose)
                .valid();
        });
    }

    bool addArray(const ArrayLayout& layout, ArrayPlace& place) {
        const std::vector<hsize_t> shape(layout.shape.begin(), layout.shape.end());
        const Hdf5Id properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
        const Hdf5Id space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose);
        if (H5Pset_layout(properties.get(), H5D_CONTIGUOUS) < 0 ||
            H5Pset_alloc_time(properties.get(), H5D_ALLOC_TIME_EARLY) < 0 ||
            H5Pset_fill_time(properties.get(), H5D_FILL_TIME_NEVER) < 0 ||
            H5Pset_obj_track_times(properties.get(), false) < 0 || !space.valid()) {
            return false;
        }
        const Hdf5Id dataset(H5Dcreate2(file_.get(), layout.name.c_str(), fileType(layout.type), space.get(),
                                        H5P_DEFAULT, properties.get(), H5P_DEFAULT),
                             H5Dclose);
        if (!dataset.valid()) return false;
        place.bytes = bytesOf(layout);
        if (place.bytes == 0) return true;
        place.offset = H5Dget_offset(dataset.get());
        return place.offset != HADDR_UNDEF;
    }

    bool addAttribute(const std::string& name, double value) {
        const Hdf5Id space(H5Screate(H5S_SCALAR), H5Sclose);
        return writeAttribute(name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, space.get(), &value);
    }

    bool addAttribute(const std::string& name, const std::vector<double>& values) {
        const hsize_t count = values.size();
        const Hdf5Id space(H5Screate_simple(1, &count, nullptr), H5Sclose);
        return writeAttribute(name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, space.get(), values.data());
    }

    bool addAttribute(const std::string& name, const std::vector<std::string>& names) {
        constexpr std::size_t width = 16;
        const hsize_t count = names.size();
        const Hdf5Id text(H5Tcopy(H5T_C_S1), H5Tclose);
        const Hdf5Id space(H5Screate_simple(1, &count, nullptr), H5Sclose);
        std::vector<char> padded(count * width);
        for (std::size_t i = 0; i < count; ++i) names[i].copy(&padded[i * width], width);
        return H5Tset_size(text.get(), width) >= 0 && H5Tset_strpad(text.get(), H5T_STR_NULLPAD) >= 0 &&
               writeAttribute(name, text.get(), text.get(), space.get(), padded.data());
    }

    bool writeAttribute(const std::string& name, hid_t stored, hid_t native, hid_t space,
                        const void* values) {
        const Hdf5Id attribute(H5Acreate2(file_.get(), name.c_str(), stored, space, H5P_DEFAULT, H5P_DEFAULT),
                               H5Aclose);
        return attribute.valid() && H5Awrite(attribute.get(), native, values) >= 0;
    }

    Hdf5Id access_;
    Hdf5Id creation_;
    Hdf5Id file_;
};

}  // namespace

void leaveHdf5Untidied() {
    H5dont_atexit();
}

Result<std::vector<ArrayPlace>> layOutFile(const std::filesystem::path& path, const FileLayout& layout) {
    MOTE_RETURN_IF_ERROR(reserve(path, layout));
    // Its errors become ours; nothing of them is for the terminal.
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    std::vector<ArrayPlace> places;
    if (Layout(path).write(layout, places)) return places;
    return Error{ErrorCode::internal, path.string(), "HDF5 cannot lay the file out"};
}

}  // namespace mote::storage
