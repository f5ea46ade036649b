// SPDX-License-Identifier: GPL-3.0-or-later
//
// Catalogue: the datasets beneath the roots, by name. Looks for folders `*.mote` with bounds on depth and
// number, reads each manifest once and again only when it changed. A broken dataset is left out and reported,
// never fatal. One owner, one thread at a time; what entries hold is immutable and may be shared.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "storage/files/file_descriptor.h"
#include "storage/files/path_beneath.h"
#include "storage/roots.h"

namespace mote::storage {

class Catalogue {
  public:
    struct Entry {
        std::string name;       ///< "ROOT/NAME" or "ROOT/FOLDER/NAME", without ".mote"
        PathBeneath directory;  ///< the root's folder, absolute, is its top
        std::shared_ptr<const proto::Manifest> manifest;
        std::uint64_t manifestBytes = 0;   ///< of its file
        std::int64_t manifestWritten = 0;  ///< when that was written, Unix time in ms
    };

    static constexpr int maxDepth = 8;  ///< folders below a root
    static constexpr std::size_t maxDatasets = 16384;
    static constexpr std::size_t maxVisited = 200000;  ///< directory entries looked at in one refresh

    /// Empty until the first refresh.
    explicit Catalogue(Roots roots) : roots_(std::move(roots)) {}

    /// Looks again; true if entries appeared, vanished or changed. Symbolic links are not followed. Never
    /// fails: what cannot be read is in errors().
    bool refresh();

    /// Ascending by name.
    const std::vector<Entry>& entries() const { return entries_; }
    /// The entry of that name, with or without ".mote"; nullptr if there is none. Valid until the next
    /// refresh.
    const Entry* find(std::string_view name) const;
    /// Why datasets or folders were left out by the last refresh.
    const std::vector<Error>& errors() const { return errors_; }
    const Roots& roots() const { return roots_; }

    /// The entries as a message: name, kind, title, steps, particles of the largest step, whether more steps
    /// may come, the size of all files as the manifest tells it, and when that was written. Touches no file.
    proto::Catalogue summary() const;

  private:
    /// Tells one version of a manifest, or of its digest, from the next.
    struct Stamp {
        std::uint64_t device = 0, inode = 0, size = 0;
        std::int64_t seconds = 0, nanoseconds = 0;  ///< when it was written last
        std::int64_t changedSeconds = 0,
                     changedNanoseconds = 0;  ///< or changed in any way, by the kernel's word
        bool operator==(const Stamp&) const = default;
    };
    struct Cached {
        Stamp stamp, digest;
        Result<std::shared_ptr<const proto::Manifest>> manifest;

        /// Whether it is what would be read again.
        bool holds(const Stamp& now, const Stamp& digestNow) const;
    };
    struct Walk;

    static bool look(const FileDescriptor& directory, const char* file, Stamp& stamp);
    void walkRoot(const Roots::Entry& root, Walk& walk);
    void addDataset(const PathBeneath& directory, std::string name, Walk& walk);

    Roots roots_;
    std::vector<Entry> entries_;
    std::vector<Error> errors_;
    std::map<std::filesystem::path, Cached> cache_;
};

}  // namespace mote::storage
