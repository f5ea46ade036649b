// SPDX-License-Identifier: GPL-3.0-or-later
//
// H5File: a foreign HDF5 file, opened for reading with everything off that could lead out of it: plugin
// filters, external and user-defined links, loops of soft links. Owned by a reader; used from one thread at a
// time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/readers/hdf5/h5_handle.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// An open group or dataset. It keeps its file open.
struct H5Object {
    H5Handle handle;
    std::string where;  ///< "run.h5:/data/3/particles", for messages
    bool group = false;
};

class H5File {
  public:
    /// True where the file begins as an HDF5 file does (at 0, 512, 1024, ... 2^20).
    static bool looksLikeHdf5(const std::filesystem::path& path);

    /// Errors: notFound, permissionDenied, corrupt.
    static Result<H5File> open(const std::filesystem::path& path);

    const std::string& name() const { return name_; }  ///< for messages
    std::uint64_t bytes() const { return bytes_; }     ///< of the file
    const H5Object& root() const { return root_; }

    /// The object at `path`, relative to `from`, or to the root where it starts with '/'. Empty and "."
    /// components are skipped. Nothing where a component is absent. Errors: unsupported (a link that leads
    /// out of the file, a loop, neither group nor dataset), corrupt.
    Result<std::optional<H5Object>> find(const H5Object& from, std::string_view path) const;

    /// The same, but absence is notFound.
    Result<H5Object> require(const H5Object& from, std::string_view path) const;

    /// Names in a group, sorted. Errors: corrupt, resourceExhausted (more than a million).
    Result<std::vector<std::string>> children(const H5Object& group) const;

  private:
    std::string name_;
    std::uint64_t bytes_ = 0;
    H5Handle file_;
    H5Object root_;
};

}  // namespace mote::prep
