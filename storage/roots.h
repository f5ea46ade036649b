// SPDX-License-Identifier: GPL-3.0-or-later
//
// Roots: the folders that a server or a job may use, each under a short name, and the names "ROOT/PATH" of
// what lies beneath them. An immutable value, safe to use from any thread.
//
// The kernel itself looks names up beneath their root (openat2), so neither ".." nor a symbolic link leads
// out; a link that stays inside is followed (on a kernel without openat2, before Linux 5.6, none is). What is
// then opened by the returned path is opened in a second step, as a real path (storage/files/real_path.h) or
// as one beneath its root (path_beneath.h): a link that was put there meanwhile is not followed.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/base/error.h"
#include "storage/files/path_beneath.h"

namespace mote::storage {

class Roots {
  public:
    struct Entry {
        std::string name;              ///< letters, digits, '_' and '-'
        std::filesystem::path folder;  ///< absolute, without symbolic links
    };

    /// Checks the form and the names alone. Errors: invalidArgument.
    static Status check(const std::vector<std::string>& texts);

    /// Reads "NAME=DIR" each. Errors: invalidArgument (form, a name twice), notFound or permissionDenied (the
    /// folder).
    static Result<Roots> parse(const std::vector<std::string>& texts);

    /// The real path of "ROOT/PATH" (or of "ROOT"), which exists. Errors: invalidArgument (form, "..", or it
    /// would lead out of the root), notFound (the root or the path), permissionDenied.
    Result<std::filesystem::path> resolveExisting(std::string_view name) const;

    /// Where "ROOT/PATH" lies if it is there, to be opened beneath its root without following any link.
    /// Errors: invalidArgument (form), notFound (the root).
    Result<PathBeneath> beneath(std::string_view name) const;

    /// The path where "ROOT/PATH" may be made: its parent exists beneath the root, it does not. Errors: as
    /// resolveExisting, alreadyExists.
    Result<std::filesystem::path> resolveNew(std::string_view name) const;

    /// "ROOT/PATH" of an absolute path that lies beneath a root (the deepest such root), ".." resolved
    /// without asking the file system; nothing if it lies beneath none.
    std::optional<std::string> nameOf(const std::filesystem::path& path) const;

    /// All roots, in the order given.
    const std::vector<Entry>& entries() const { return entries_; }
    bool empty() const { return entries_.empty(); }

  private:
    std::vector<Entry> entries_;
};

}  // namespace mote::storage
