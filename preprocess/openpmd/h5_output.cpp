// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/openpmd/h5_output.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>

#include "protocol/base/system_error.h"
#include "storage/files/file_descriptor.h"

namespace mote::prep {
namespace {

bool setAttribute(hid_t object, const char* name, hid_t type, hid_t memoryType, hid_t space,
                  const void* value) {
    const H5Handle attribute(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    return attribute.ok() && H5Awrite(attribute.get(), memoryType, value) >= 0;
}

bool setScalar(hid_t object, const char* name, hid_t type, hid_t memoryType, const void* value) {
    const H5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    return space.ok() && setAttribute(object, name, type, memoryType, space.get(), value);
}

bool setArray(hid_t object, const char* name, hid_t type, hid_t memoryType, hsize_t size,
              const void* values) {
    const H5Handle space(H5Screate_simple(1, &size, nullptr), H5Sclose);
    return space.ok() && setAttribute(object, name, type, memoryType, space.get(), values);
}

/// HDF5 writes the kernel's number into its message: "... errno = 28, error message = ...".
herr_t findNumber(unsigned, const H5E_error2_t* entry, void* number) {
    constexpr std::string_view mark = "errno = ";
    if (entry->desc == nullptr || *static_cast<int*>(number) != 0) return 0;
    if (const char* found = std::strstr(entry->desc, mark.data())) {
        *static_cast<int*>(number) = std::atoi(found + mark.size());
    }
    return 0;
}

}  // namespace

H5Handle createFile(const std::string& path) {
    const H5Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
    const H5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    if (!creation.ok() || !access.ok()) return {};
    H5Pset_obj_track_times(creation.get(), false);
    H5Pset_fclose_degree(access.get(), H5F_CLOSE_STRONG);
    return {H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation.get(), access.get()), H5Fclose};
}

void forgetUnwritten(hid_t file) {
    void* handle = nullptr;
    if (H5Fget_vfd_handle(file, H5P_DEFAULT, &handle) < 0 || handle == nullptr) return;
    const storage::FileDescriptor memory(::memfd_create("discarded", MFD_CLOEXEC));
    if (memory.valid()) ::dup3(memory.get(), *static_cast<int*>(handle), O_CLOEXEC);
}

H5Handle createGroup(hid_t parent, const std::string& path) {
    const H5Handle links(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
    const H5Handle creation(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
    if (!links.ok() || !creation.ok()) return {};
    H5Pset_create_intermediate_group(links.get(), 1);
    H5Pset_obj_track_times(creation.get(), false);
    return {H5Gcreate2(parent, path.c_str(), links.get(), creation.get(), H5P_DEFAULT), H5Gclose};
}

H5Handle createColumn(hid_t parent, const char* name, hid_t type, std::uint64_t rows) {
    const hsize_t extent = rows;
    const H5Handle space(H5Screate_simple(1, &extent, nullptr), H5Sclose);
    const H5Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    if (!space.ok() || !creation.ok()) return {};
    H5Pset_layout(creation.get(), H5D_CONTIGUOUS);
    H5Pset_alloc_time(creation.get(), H5D_ALLOC_TIME_EARLY);
    H5Pset_fill_time(creation.get(), H5D_FILL_TIME_NEVER);
    H5Pset_obj_track_times(creation.get(), false);
    return {H5Dcreate2(parent, name, type, space.get(), H5P_DEFAULT, creation.get(), H5P_DEFAULT), H5Dclose};
}

bool writeColumn(hid_t file, const std::string& path, hid_t type, std::uint64_t first, std::size_t rows,
                 const void* values) {
    const H5Handle dataset(H5Dopen2(file, path.c_str(), H5P_DEFAULT), H5Dclose);
    if (!dataset.ok()) return false;
    const hsize_t start = first, count = rows;
    const H5Handle inFile(H5Dget_space(dataset.get()), H5Sclose);
    const H5Handle inMemory(H5Screate_simple(1, &count, nullptr), H5Sclose);
    return inFile.ok() && inMemory.ok() &&
           H5Sselect_hyperslab(inFile.get(), H5S_SELECT_SET, &start, nullptr, &count, nullptr) >= 0 &&
           H5Dwrite(dataset.get(), type, inMemory.get(), inFile.get(), H5P_DEFAULT, values) >= 0;
}

bool setText(hid_t object, const char* name, std::string_view text) {
    const H5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    if (!type.ok() || H5Tset_size(type.get(), text.size() + 1) < 0) return false;
    return setScalar(object, name, type.get(), type.get(), std::string(text).c_str());
}

bool setDouble(hid_t object, const char* name, double value) {
    return setScalar(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value);
}

bool setDoubles(hid_t object, const char* name, std::span<const double> values) {
    return setArray(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values.size(), values.data());
}

bool setUnsigned32(hid_t object, const char* name, std::uint32_t value) {
    return setScalar(object, name, H5T_STD_U32LE, H5T_NATIVE_UINT32, &value);
}

bool setUnsigned64(hid_t object, const char* name, std::uint64_t value) {
    return setScalar(object, name, H5T_STD_U64LE, H5T_NATIVE_UINT64, &value);
}

bool setExtent(hid_t object, const char* name, std::uint64_t value) {
    return setArray(object, name, H5T_STD_U64LE, H5T_NATIVE_UINT64, 1, &value);
}

H5Errors::H5Errors() {
    // HDF5 1.10 cannot close a file whose flush has failed, and crashes on what is left of it when it tidies
    // up at the end of the process. We close all that we open: nothing is left to tidy. In time only as
    // HDF5's very first call.
    H5dont_atexit();
    H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
    H5Eset_auto2(H5E_DEFAULT, keep, this);
}

H5Errors::~H5Errors() {
    H5Eset_auto2(H5E_DEFAULT, function_, data_);
}

herr_t H5Errors::keep(hid_t stack, void* self) {
    // Now, not later: closing what the failed call left open clears the stack.
    H5Ewalk2(stack, H5E_WALK_UPWARD, findNumber, &static_cast<H5Errors*>(self)->number_);
    return 0;
}

Error H5Errors::failure(const std::string& where) const {
    if (number_ != 0) return systemError(number_, where, "cannot be written");
    return {ErrorCode::internal, where, "HDF5 cannot write the file"};
}

}  // namespace mote::prep
