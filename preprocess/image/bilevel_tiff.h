// SPDX-License-Identifier: GPL-3.0-or-later
//
// TIFF pictures that do not say how many bits a sample has: one, by the format (TIFF 6.0, section 3), where
// OpenImageIO takes eight. Called from one thread.
#pragma once

#include <filesystem>
#include <optional>

#include "protocol/scene/error.h"
#include "storage/image/image_file.h"

namespace mote::prep {

/// The luminance, 0 and 1, of such a picture; nothing where `path`, a TIFF file, is none. `mostPixels`: what
/// may be taken. Errors: corrupt, unsupported (several samples a pixel, tiles), resourceExhausted.
Result<std::optional<storage::Luminance>> readBilevelTiff(const std::filesystem::path& path,
                                                          std::uint64_t mostPixels);

}  // namespace mote::prep
