// SPDX-License-Identifier: GPL-3.0-or-later
//
// H5TestFile: writes small HDF5 files for the tests, with every oddity that they need. One owner, one thread.
// Throws std::runtime_error where HDF5 refuses.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace mote::test {

class H5TestFile {
  public:
    /// Behind `userBlock` bytes of something else; `latest`: in HDF5's newest format, not its oldest.
    explicit H5TestFile(const std::filesystem::path& path, hsize_t userBlock = 0, bool latest = false);
    ~H5TestFile();
    H5TestFile(const H5TestFile&) = delete;
    H5TestFile& operator=(const H5TestFile&) = delete;

    hid_t id() const { return file_; }
    /// Makes a group and those above it; nothing where it is there already.
    void group(const std::string& path);

    void attribute(const std::string& object, const char* name, double value);
    void attribute(const std::string& object, const char* name, std::int64_t value);
    void attribute(const std::string& object, const char* name, const std::vector<double>& values);
    void attribute(const std::string& object, const char* name, const std::vector<std::int32_t>& values);
    /// Text of fixed length, as a scalar.
    void text(const std::string& object, const char* name, const std::string& value);
    /// Text of variable length, as a scalar or as an array of one.
    void variableText(const std::string& object, const char* name, const std::string& value,
                      bool array = false);

    void data(const std::string& path, const std::vector<double>& values);
    void data(const std::string& path, const std::vector<float>& values);
    void data(const std::string& path, const std::vector<std::int32_t>& values);
    void data(const std::string& path, const std::vector<std::int64_t>& values);
    void data(const std::string& path, const std::vector<std::uint64_t>& values);
    /// Chunked and gzipped with shuffle.
    void gzipped(const std::string& path, const std::vector<double>& values, hsize_t chunk);
    /// A dataset of any extent and creation properties, without values.
    void empty(const std::string& path, const std::vector<hsize_t>& extent, hid_t creation = H5P_DEFAULT);

    /// Values of any type, extent and creation properties.
    void write(const std::string& path, hid_t type, const void* values, const std::vector<hsize_t>& extent,
               hid_t creation);

    /// A constant component: a group with `value` and `shape`.
    void constant(const std::string& path, double value, std::int64_t rows, double unitSI = 1.0);

  private:
    void writeAttribute(const std::string& object, const char* name, hid_t type, hid_t space,
                        const void* value);

    hid_t file_ = -1;
};

}  // namespace mote::test
