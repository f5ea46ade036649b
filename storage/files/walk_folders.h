// SPDX-License-Identifier: GPL-3.0-or-later
//
// Walks the folders beneath one, which others may change meanwhile. A function without state, any thread.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>

#include "protocol/base/error.h"

namespace mote::storage {

struct FolderWalk {
    enum class Next { enter, pass, stop };

    int maxDepth = 0;  ///< folders of `top` have depth 0; those of greater depth are not looked for
    /// Called for each folder, its path relative to `top`, in no order; files and symbolic links are not
    /// shown.
    std::function<Next(const std::filesystem::path& folder)> visit;
    /// Called for each entry of whatever type, before visit(); false: stop.
    std::function<bool()> count;
    /// Called with a folder that cannot be listed; the walk goes on with the others.
    std::function<void(const std::filesystem::path& folder, int error)> unreadable;
};

/// A folder that vanishes while it is walked is passed over like one that was never there, as is one that
/// this user may not list; all others are found whatever comes and goes beside them.
void walkFolders(const std::filesystem::path& top, const FolderWalk& walk);

}  // namespace mote::storage
