// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which files make a stack of pictures, and in which order. Functions without state.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "protocol/scene/error.h"

namespace mote::prep {

/// Whether an input names several files: a folder, or a name with * or ? that no file has.
bool namesPictures(const std::filesystem::path& input);

/// Its PNG and TIFF files, by their endings, or all files of such names, in natural order. Errors: notFound
/// (none), corrupt (numbers leave one out), resourceExhausted (more than VolumeShape::maxDimension),
/// permissionDenied, internal.
Result<std::vector<std::filesystem::path>> pictureFiles(const std::filesystem::path& input);

/// Orders names in which numbers count as numbers: slice2 before slice10.
bool naturallyLess(std::string_view a, std::string_view b);

}  // namespace mote::prep
