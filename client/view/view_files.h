// SPDX-License-Identifier: GPL-3.0-or-later
//
// ViewFiles: where views are opened from and saved to, as the panel asks for it. Owned by the viewer; main
// thread.
#pragma once

#include <filesystem>

#include "client/view/film/path_prompt.h"

namespace mote::client {

struct ViewFiles {
    PathPrompt opening{"Open view", "Open", "view.json", false};
    PathPrompt saving{"Save view", "Save", "", true};
};

/// `usual`, or with the first number behind it that no file has: "view-2.json".
std::filesystem::path freshPath(const std::filesystem::path& usual);

}  // namespace mote::client
