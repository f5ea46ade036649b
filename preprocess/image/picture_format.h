// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which format a picture file has, by its first bytes and not by its name: OpenImageIO would try a hundred
// formats on a file that nobody vouches for. Pure, but for the file.
#pragma once

#include <filesystem>

#include "protocol/scene/error.h"

namespace mote::prep {

/// OpenImageIO's name of it: "png", "jpeg", "tiff" or "openexr". Errors: notFound, permissionDenied,
/// unsupported (none of them), corrupt (an empty file; a JPEG whose end is missing, of which its library
/// would make up the rest).
Result<const char*> pictureFormat(const std::filesystem::path& path);

}  // namespace mote::prep
