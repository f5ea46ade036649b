// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/particles/step_hdf5.h"

#include <algorithm>

#include "storage/particles/hdf5_id.h"

namespace mote::storage {
namespace {

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
    explicit Layout(const std::filesystem::path& path)
        : access_(H5Pcreate(H5P_FILE_ACCESS), H5Pclose),
          creation_(H5Pcreate(H5P_FILE_CREATE), H5Pclose),
          file_(create(path), H5Fclose) {}

    bool write(const StepShape& shape, const StepAttributes& attributes, StepFile::Places& places) {
        if (!file_.valid() || !addGroups()) return false;
        for (std::size_t i = 0; i < stepArrays.size(); ++i) {
            const auto extent = shape.of(static_cast<StepArray>(i));
            if (!addArray(stepArrays[i], {extent.begin(), extent.end()}, places[i])) return false;
        }
        return addAttributes(attributes) && file_.close();
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

    bool addGroups() {
        const Hdf5Id properties(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
        if (H5Pset_obj_track_times(properties.get(), false) < 0) return false;
        return std::all_of(stepGroups.begin(), stepGroups.end(), [&](const char* name) {
            return Hdf5Id(H5Gcreate2(file_.get(), name, H5P_DEFAULT, properties.get(), H5P_DEFAULT), H5Gclose)
                .valid();
        });
    }

    bool addArray(const StepArrayLayout& layout, const std::vector<hsize_t>& shape, StepFile::Place& place) {
        const Hdf5Id properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
        const Hdf5Id space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose);
        if (H5Pset_layout(properties.get(), H5D_CONTIGUOUS) < 0 ||
            H5Pset_alloc_time(properties.get(), H5D_ALLOC_TIME_EARLY) < 0 ||
            H5Pset_fill_time(properties.get(), H5D_FILL_TIME_NEVER) < 0 ||
            H5Pset_obj_track_times(properties.get(), false) < 0 || !space.valid()) {
            return false;
        }
        const Hdf5Id dataset(H5Dcreate2(file_.get(), layout.name, fileType(layout.type), space.get(),
                                        H5P_DEFAULT, properties.get(), H5P_DEFAULT),
                             H5Dclose);
        if (!dataset.valid()) return false;
        place.bytes = H5Tget_size(fileType(layout.type));
        for (const auto length : shape) place.bytes *= length;
        if (place.bytes == 0) return true;
        place.offset = H5Dget_offset(dataset.get());
        return place.offset != HADDR_UNDEF;
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

    bool addAttributes(const StepAttributes& attributes) {
        constexpr std::size_t width = 16;  // of an axis' name, padded with zeros
        const Hdf5Id text(H5Tcopy(H5T_C_S1), H5Tclose);
        std::array<char, 3 * width> names{};
        for (std::size_t i = 0; i < 3; ++i) attributes.axes[i].copy(&names[i * width], width);
        return H5Tset_size(text.get(), width) >= 0 && H5Tset_strpad(text.get(), H5T_STR_NULLPAD) >= 0 &&
               addAttribute("axes", text.get(), text.get(), {3}, names.data()) &&
               addAttribute("bounds_min", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, {3},
                            attributes.boundsMin.data()) &&
               addAttribute("bounds_max", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, {3},
                            attributes.boundsMax.data()) &&
               addAttribute("total_weight", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, {}, &attributes.totalWeight);
    }

    Hdf5Id access_;
    Hdf5Id creation_;
    Hdf5Id file_;
};

}  // namespace

Result<StepFile::Places> layOutStep(const std::filesystem::path& path, const StepShape& shape,
                                    const StepAttributes& attributes) {
    // Its errors become ours; nothing of them is for the terminal.
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    StepFile::Places places;
    if (Layout(path).write(shape, attributes, places)) return places;
    return Error{ErrorCode::internal, path.string(), "HDF5 cannot lay the file out"};
}

}  // namespace mote::storage
