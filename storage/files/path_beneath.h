// SPDX-License-Identifier: GPL-3.0-or-later
//
// PathBeneath: a path in two parts. Its top was given by who may say where things lie: a root of the server,
// or what a user names on the command line. What lies beneath the top is opened there by the kernel, and no
// link on the way is followed: whatever takes a folder's or a file's place after it was found, nothing
// outside is opened. An immutable value that holds nothing open; any thread.
#pragma once

#include <concepts>
#include <filesystem>
#include <string>
#include <utility>

#include "storage/files/file_descriptor.h"

namespace mote::storage {

class PathBeneath {
  public:
    PathBeneath() = default;
    /// All of it is the top. On purpose implicit: who has a path alone trusts the way that leads there.
    template <std::convertible_to<std::filesystem::path> Path>
    PathBeneath(const Path& top) : whole_(top), top_(whole_) {}
    /// `beneath`: relative, without ".."; "" is the top itself.
    PathBeneath(std::filesystem::path top, std::filesystem::path beneath)
        : whole_(beneath.empty() ? top : top / beneath), top_(std::move(top)), beneath_(std::move(beneath)) {}

    /// Of what lies in an open folder, whatever takes the place where it was found, for as long as it is
    /// open; `name`: what the folder is called.
    static PathBeneath in(const FileDescriptor& folder, std::filesystem::path name) {
        return {std::move(name), "/proc/self/fd/" + std::to_string(folder.get()), {}};
    }

    /// Of one file or folder in it, by a name without "..".
    friend PathBeneath operator/(const PathBeneath& folder, const std::filesystem::path& name) {
        return {folder.whole_ / name, folder.top_, folder.beneath_ / name};
    }
    bool operator==(const PathBeneath&) const = default;

    /// For messages, and to tell one from another; not to be opened.
    const std::filesystem::path& path() const { return whole_; }
    std::string string() const { return whole_.string(); }

    /// `flags` as for open(2), O_CLOEXEC besides. An invalid one, and errno, if that fails: ELOOP if
    /// the last part or one beneath the top is a link (before Linux 5.6 also ENOTDIR).
    FileDescriptor open(int flags) const;

  private:
    PathBeneath(std::filesystem::path whole, std::filesystem::path top, std::filesystem::path beneath)
        : whole_(std::move(whole)), top_(std::move(top)), beneath_(std::move(beneath)) {}

    std::filesystem::path whole_, top_, beneath_;
};

}  // namespace mote::storage
