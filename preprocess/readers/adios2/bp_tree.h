// SPDX-License-Identifier: GPL-3.0-or-later
//
// BpTree: an openPMD file of ADIOS2 as the HDF5 file that it would be: groups, attributes, and datasets that
// have an extent and no values, in memory, where the readers of openPMD find all that they look for. Values
// come from BpFile. Iterations that are steps of the file (variableBased) stand as groups of their own. What
// the file says is bounded here. Shared by an H5File and its datasets; one thread.
#pragma once

#include <hdf5.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "preprocess/readers/adios2/bp_file.h"
#include "preprocess/readers/hdf5/h5_file.h"
#include "protocol/base/error.h"

namespace mote::prep {

class BpTree {
  public:
    /// Whether a folder is a file of ADIOS2 (BP4, BP5).
    static bool isBp(const std::filesystem::path& folder);
    /// Whether it is, and can be read here.
    static bool reads(const std::filesystem::path& folder);

    /// Errors: corrupt, unsupported, resourceExhausted.
    static Result<std::shared_ptr<BpTree>> open(const std::filesystem::path& folder);

    hid_t file() const { return tree_.get(); }
    std::uint64_t bytes() const { return bytes_; }  ///< of the folder's files

  private:
    friend class BpValues;

    Status build(const std::string& name);
    Status addSteps(const std::string& base, const std::string& name);
    Status add(const BpContents& contents, const std::string& from, const std::string& to,
               const std::string& name);
    Status addVariable(const std::string& path, const BpVariable& variable, const std::string& where);
    Status addAttribute(const std::string& path, const BpAttribute& attribute, const std::string& where);
    H5Handle openOrMake(const std::string& path);

    std::unique_ptr<BpFile> values_;
    H5Handle tree_;
    std::uint64_t bytes_ = 0;
    std::map<std::string, BpVariable> variables_;  ///< by their absolute paths in the tree
};

/// The values of one dataset of a tree. Owned by an H5Numbers; one thread.
class BpValues {
  public:
    /// All of them are there, and no more than the file's bytes and what compression can save. Errors:
    /// corrupt, unsupported.
    static Result<std::unique_ptr<BpValues>> open(std::shared_ptr<BpTree> tree, const H5Object& dataset);

    /// A box of them, which lies within the extent, in the dataset's type. Errors, at `where`: as open.
    Status read(std::span<const hsize_t> first, std::span<const hsize_t> count, void* values,
                const std::string& where);

  private:
    BpValues(std::shared_ptr<BpTree> tree, BpVariable variable)
        : tree_(std::move(tree)), variable_(std::move(variable)) {}
    Status readBox(std::span<const hsize_t> first, std::span<const hsize_t> count, void* values,
                   const std::string& where);

    std::shared_ptr<BpTree> tree_;
    BpVariable variable_;
    // Of a column: what was read last. A block that is compressed is undone whole for each row of it.
    std::vector<std::byte> window_;
    std::uint64_t windowBegin_ = 0;
};

}  // namespace mote::prep
