// SPDX-License-Identifier: GPL-3.0-or-later
//
// H5File: a foreign HDF5 file, opened for reading with everything off that could lead out of it: plugin
// filters, external and user-defined links, loops of soft links; or a folder of ADIOS2, as the file that it
// would be (BpTree). Owned by a reader; used from one thread at a time.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "protocol/base/error.h"
#include "storage/files/file_descriptor.h"

namespace mote::prep {

class BpTree;

/// HDF5's messages on stderr, off for this thread: what goes wrong becomes an Error of ours.
inline void silenceHdf5() {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

/// An HDF5 identifier, closed when it goes. One owner, one thread at a time.
class H5Handle {
  public:
    using Close = herr_t (*)(hid_t);

    H5Handle() = default;
    /// Takes `id`, negative where HDF5 refused to make it.
    H5Handle(hid_t id, Close close) : id_(id), close_(close) {}
    ~H5Handle() { reset(); }
    H5Handle(H5Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
    H5Handle& operator=(H5Handle&& other) noexcept {
        if (this != &other) {
            reset();
            id_ = std::exchange(other.id_, -1);
            close_ = other.close_;
        }
        return *this;
    }

    bool ok() const { return id_ >= 0; }
    hid_t get() const { return id_; }

  private:
    void reset() {
        if (id_ >= 0) close_(id_);
        id_ = -1;
    }

    hid_t id_ = -1;
    Close close_ = nullptr;
};

/// An open group or dataset. It keeps its file open.
struct H5Object {
    H5Handle handle;
    std::string where;  ///< "run.h5:/data/3/particles", for messages
    bool group = false;
};

class H5File {
  public:
    /// True where the file begins as an HDF5 file does (at 0, 512, 1024, ... 2^20), or is a folder of ADIOS2
    /// that can be read.
    static bool looksLikeHdf5(const std::filesystem::path& path);

    /// Errors: notFound, permissionDenied, corrupt; unsupported.
    static Result<H5File> open(const std::filesystem::path& path);

    const std::string& name() const { return name_; }  ///< for messages
    std::uint64_t bytes() const { return bytes_; }     ///< of the file
    /// Where its values lie, if it is a folder of ADIOS2; else null.
    const std::shared_ptr<BpTree>& bp() const { return bp_; }
    /// The open file itself, for what is read without HDF5; null if it is a folder of ADIOS2.
    const std::shared_ptr<const storage::FileDescriptor>& descriptor() const { return descriptor_; }
    const H5Object& root() const { return root_; }

    /// Makes the group at `path` the root from which absolute paths are found. Errors: notFound, corrupt.
    Status enter(const std::string& path);

    /// The object at `path`, relative to `from`, or to the root where it starts with '/'. Empty and "."
    /// components are skipped. Nothing where a component is absent. Errors: unsupported (a link that leads
    /// out of the file, a loop, neither group nor dataset), corrupt.
    Result<std::optional<H5Object>> find(const H5Object& from, std::string_view path) const;

    /// The same, but absence is notFound.
    Result<H5Object> require(const H5Object& from, std::string_view path) const;

    /// Names in a group, sorted. Errors: corrupt, resourceExhausted (more than a million).
    Result<std::vector<std::string>> children(const H5Object& group) const;

  private:
    Status openHdf5(const std::filesystem::path& path);

    std::string name_;
    std::uint64_t bytes_ = 0;
    std::shared_ptr<BpTree> bp_;
    std::shared_ptr<const storage::FileDescriptor> descriptor_;
    H5Handle file_;
    H5Object root_;
};

}  // namespace mote::prep
