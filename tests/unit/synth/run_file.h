// SPDX-License-Identifier: GPL-3.0-or-later
//
// RunFile: a finished run read back with plain HDF5, for the tests of the writer. One owner, one thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "preprocess/readers/hdf5/h5_file.h"

namespace mote::test {

class RunFile {
  public:
    explicit RunFile(const std::filesystem::path& path);
    bool ok() const { return file_.ok(); }

    /// An attribute of the object at `path`; empty, or NaN, if it is absent.
    std::string text(const std::string& path, const char* name) const;
    double number(const std::string& path, const char* name) const;
    std::vector<double> numbers(const std::string& path, const char* name) const;

    std::vector<double> column(const std::string& path) const;
    std::vector<std::uint64_t> ids(const std::string& path) const;
    bool isDataset(const std::string& path) const;
    bool has(const std::string& path) const;
    std::vector<std::string> children(const std::string& path) const;

  private:
    prep::H5Handle file_;
};

}  // namespace mote::test
