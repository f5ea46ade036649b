// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/readers/h5_test_file.h"

#include <stdexcept>

namespace mote::test {
namespace {

/// What HDF5 returned, where that is no failure.
template <class Id>
Id checked(Id result, const char* what) {
    if (result < 0) throw std::runtime_error(std::string("HDF5 refused: ") + what);
    return result;
}

}  // namespace

H5TestFile::H5TestFile(const std::filesystem::path& path, hsize_t userBlock, bool latest) {
    const hid_t creation = H5Pcreate(H5P_FILE_CREATE), access = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_userblock(creation, userBlock);
    if (latest) H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
    file_ = checked(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation, access), "H5Fcreate");
    H5Pclose(creation);
    H5Pclose(access);
}

H5TestFile::~H5TestFile() {
    H5Fclose(file_);
}

void H5TestFile::group(const std::string& path) {
    for (std::size_t at = 1; at != std::string::npos && path.size() > 1;) {
        at = path.find('/', at + 1);
        const std::string part = path.substr(0, at);
        if (H5Lexists(file_, part.c_str(), H5P_DEFAULT) > 0) continue;
        H5Gclose(
            checked(H5Gcreate2(file_, part.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), "H5Gcreate"));
    }
}

void H5TestFile::writeAttribute(const std::string& object, const char* name, hid_t type, hid_t space,
                                const void* value) {
    const hid_t at = checked(H5Oopen(file_, object.c_str(), H5P_DEFAULT), "H5Oopen");
    if (H5Aexists(at, name) > 0) H5Adelete(at, name);
    const hid_t attribute = checked(H5Acreate2(at, name, type, space, H5P_DEFAULT, H5P_DEFAULT), "H5Acreate");
    checked(H5Awrite(attribute, type, value), "H5Awrite");
    H5Aclose(attribute);
    H5Sclose(space);
    H5Oclose(at);
}

void H5TestFile::attribute(const std::string& object, const char* name, double value) {
    writeAttribute(object, name, H5T_NATIVE_DOUBLE, H5Screate(H5S_SCALAR), &value);
}

void H5TestFile::attribute(const std::string& object, const char* name, std::int64_t value) {
    writeAttribute(object, name, H5T_NATIVE_INT64, H5Screate(H5S_SCALAR), &value);
}

void H5TestFile::attribute(const std::string& object, const char* name, const std::vector<double>& values) {
    const hsize_t size = values.size();
    writeAttribute(object, name, H5T_NATIVE_DOUBLE, H5Screate_simple(1, &size, nullptr), values.data());
}

void H5TestFile::attribute(const std::string& object, const char* name,
                           const std::vector<std::int32_t>& values) {
    const hsize_t size = values.size();
    writeAttribute(object, name, H5T_NATIVE_INT32, H5Screate_simple(1, &size, nullptr), values.data());
}

void H5TestFile::text(const std::string& object, const char* name, const std::string& value) {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, value.empty() ? 1 : value.size());
    H5Tset_strpad(type, H5T_STR_NULLPAD);
    writeAttribute(object, name, type, H5Screate(H5S_SCALAR), value.c_str());
    H5Tclose(type);
}

void H5TestFile::variableText(const std::string& object, const char* name, const std::string& value,
                              bool array) {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, H5T_VARIABLE);
    const hsize_t one = 1;
    const char* pointer = value.c_str();
    writeAttribute(object, name, type, array ? H5Screate_simple(1, &one, nullptr) : H5Screate(H5S_SCALAR),
                   &pointer);
    H5Tclose(type);
}

void H5TestFile::write(const std::string& path, hid_t type, const void* values,
                       const std::vector<hsize_t>& extent, hid_t creation) {
    group(path.substr(0, path.rfind('/')));
    // A chunk may be longer than a dimension that can still grow.
    const bool grows = creation != H5P_DEFAULT && H5Pget_layout(creation) == H5D_CHUNKED;
    const std::vector<hsize_t> unlimited(extent.size(), H5S_UNLIMITED);
    const hid_t space =
        H5Screate_simple(static_cast<int>(extent.size()), extent.data(), grows ? unlimited.data() : nullptr);
    const hid_t dataset = checked(
        H5Dcreate2(file_, path.c_str(), type, space, H5P_DEFAULT, creation, H5P_DEFAULT), "H5Dcreate");
    if (values != nullptr)
        checked(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), "H5Dwrite");
    H5Dclose(dataset);
    H5Sclose(space);
}

void H5TestFile::data(const std::string& path, const std::vector<double>& values) {
    write(path, H5T_NATIVE_DOUBLE, values.data(), {values.size()}, H5P_DEFAULT);
}

void H5TestFile::data(const std::string& path, const std::vector<float>& values) {
    write(path, H5T_NATIVE_FLOAT, values.data(), {values.size()}, H5P_DEFAULT);
}

void H5TestFile::data(const std::string& path, const std::vector<std::int32_t>& values) {
    write(path, H5T_NATIVE_INT32, values.data(), {values.size()}, H5P_DEFAULT);
}

void H5TestFile::data(const std::string& path, const std::vector<std::int64_t>& values) {
    write(path, H5T_NATIVE_INT64, values.data(), {values.size()}, H5P_DEFAULT);
}

void H5TestFile::data(const std::string& path, const std::vector<std::uint64_t>& values) {
    write(path, H5T_NATIVE_UINT64, values.data(), {values.size()}, H5P_DEFAULT);
}

void H5TestFile::gzipped(const std::string& path, const std::vector<double>& values, hsize_t chunk) {
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_chunk(creation, 1, &chunk);
    H5Pset_shuffle(creation);
    H5Pset_deflate(creation, 6);
    write(path, H5T_NATIVE_DOUBLE, values.data(), {values.size()}, creation);
    H5Pclose(creation);
}

void H5TestFile::empty(const std::string& path, const std::vector<hsize_t>& extent, hid_t creation) {
    write(path, H5T_NATIVE_DOUBLE, nullptr, extent, creation);
}

void H5TestFile::constant(const std::string& path, double value, std::int64_t rows, double unitSI) {
    group(path);
    attribute(path, "value", value);
    attribute(path, "shape", rows);
    attribute(path, "unitSI", unitSI);
}

}  // namespace mote::test
