// SPDX-License-Identifier: GPL-3.0-or-later
//
// A picture file as linear luminance: PNG, JPEG, TIFF or OpenEXR, of 8, 16 or 32 bits or floats, grey or in
// colour, upright (as its orientation says), laid on white where it is transparent. Called from one thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "preprocess/progress.h"
#include "protocol/scene/error.h"
#include "storage/image/luminance.h"

namespace mote::prep {

struct Picture {
    storage::Luminance luminance;
    std::string colorSpace;     ///< how the file encodes intensity: "sRGB", "linear" or "gamma 2.2"
    bool color = false;         ///< three channels, of which the luminance is that of ITU-R BT.709
    bool transparent = false;   ///< had an alpha channel
    std::uint64_t invalid = 0;  ///< pixels that are not finite, taken as white
};

/// `memory` in bytes: what reading may take; 0: what the largest picture takes (2^28 pixels). Errors:
/// notFound, permissionDenied, unsupported (another format; deep or solid pictures; a colour space that is
/// not known), corrupt (also a picture without pixels), resourceExhausted (too large: said before memory is
/// taken), cancelled.
Result<Picture> readPicture(const std::filesystem::path& path, std::uint64_t memory, Progress& progress);

}  // namespace mote::prep
