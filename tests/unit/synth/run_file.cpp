// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/synth/run_file.h"

#include <cmath>

namespace mote::test {

using prep::H5Handle;

RunFile::RunFile(const std::filesystem::path& path)
    : file_(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose) {}

std::string RunFile::text(const std::string& path, const char* name) const {
    const H5Handle object(H5Oopen(file_.get(), path.c_str(), H5P_DEFAULT), H5Oclose);
    if (!object.ok() || H5Aexists(object.get(), name) <= 0) return {};
    const H5Handle attribute(H5Aopen(object.get(), name, H5P_DEFAULT), H5Aclose);
    const H5Handle type(H5Aget_type(attribute.get()), H5Tclose);
    std::string value(H5Tget_size(type.get()), '\0');
    H5Aread(attribute.get(), type.get(), value.data());
    return value.c_str();
}

std::vector<double> RunFile::numbers(const std::string& path, const char* name) const {
    const H5Handle object(H5Oopen(file_.get(), path.c_str(), H5P_DEFAULT), H5Oclose);
    if (!object.ok() || H5Aexists(object.get(), name) <= 0) return {};
    const H5Handle attribute(H5Aopen(object.get(), name, H5P_DEFAULT), H5Aclose);
    const H5Handle space(H5Aget_space(attribute.get()), H5Sclose);
    std::vector<double> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space.get())));
    H5Aread(attribute.get(), H5T_NATIVE_DOUBLE, values.data());
    return values;
}

double RunFile::number(const std::string& path, const char* name) const {
    const auto values = numbers(path, name);
    return values.empty() ? std::nan("") : values.front();
}

std::vector<double> RunFile::column(const std::string& path) const {
    const H5Handle dataset(H5Dopen2(file_.get(), path.c_str(), H5P_DEFAULT), H5Dclose);
    const H5Handle space(H5Dget_space(dataset.get()), H5Sclose);
    std::vector<double> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space.get())));
    H5Dread(dataset.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    return values;
}

std::vector<std::uint64_t> RunFile::ids(const std::string& path) const {
    std::vector<std::uint64_t> values(column(path).size());
    const H5Handle dataset(H5Dopen2(file_.get(), path.c_str(), H5P_DEFAULT), H5Dclose);
    H5Dread(dataset.get(), H5T_NATIVE_UINT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    return values;
}

bool RunFile::isDataset(const std::string& path) const {
    const H5Handle object(H5Oopen(file_.get(), path.c_str(), H5P_DEFAULT), H5Oclose);
    return object.ok() && H5Iget_type(object.get()) == H5I_DATASET;
}

bool RunFile::has(const std::string& path) const {
    return H5Lexists(file_.get(), path.c_str(), H5P_DEFAULT) > 0;
}

std::vector<std::string> RunFile::children(const std::string& path) const {
    std::vector<std::string> names;
    const auto add = [](hid_t, const char* name, const H5L_info_t*, void* list) -> herr_t {
        static_cast<std::vector<std::string>*>(list)->push_back(name);
        return 0;
    };
    H5Literate_by_name(file_.get(), path.c_str(), H5_INDEX_NAME, H5_ITER_INC, nullptr, add, &names,
                       H5P_DEFAULT);
    return names;
}

}  // namespace mote::test
