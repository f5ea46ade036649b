// SPDX-License-Identifier: GPL-3.0-or-later
//
// JobRoots: the configured folders and the names beneath them that a job request may use. An immutable value.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/scene/error.h"

namespace mote::server {

class JobRoots {
  public:
    /// A file or folder that a request names: `relative` to the root's folder.
    struct Place {
        std::filesystem::path root;
        std::filesystem::path relative;

        std::filesystem::path path() const { return root / relative; }
    };

    /// From "NAME=DIR" each. Errors: invalidArgument (form, a name twice), notFound (the folder).
    static Result<JobRoots> parse(const std::vector<std::string>& texts);

    /// Where "ROOT/PATH" lies; touches no file. Errors: invalidArgument with `field` (form, "..", too long),
    /// notFound (the root).
    Result<Place> locate(std::string_view name, std::string_view field) const;

    /// Whether the place exists, looked up beneath its root as the kernel understands it: no link leads out.
    /// Errors: invalidArgument (it would lead out), permissionDenied, internal.
    static Result<bool> exists(const Place& place, std::string_view field);

    /// "NAME=DIR" each, folders absolute: what mote-prep's --root takes.
    std::vector<std::string> options() const;
    std::vector<std::filesystem::path> folders() const;

  private:
    struct Root {
        std::string name;
        std::filesystem::path folder;
    };
    std::vector<Root> roots_;
};

}  // namespace mote::server
