// SPDX-License-Identifier: GPL-3.0-or-later
//
// A picture file as linear light: PNG, JPEG, TIFF or OpenEXR, of 8, 16 or 32 bits or floats, grey or in
// colour, upright (as its orientation says), laid on white if it is transparent. Its format is told by its
// first bytes and not by its name: OpenImageIO would try a hundred formats on a file that nobody vouches for.
// Called from one thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "preprocess/job.h"
#include "protocol/base/error.h"
#include "storage/image/image_file.h"

namespace mote::prep {

/// `orientation` as in Exif and TIFF (tag 274), 1 to 8; the picture as it is for 1 and for other numbers.
storage::Luminance upright(storage::Luminance picture, int orientation);

/// OpenImageIO's name of it: "png", "jpeg", "tiff" or "openexr". Errors: notFound, permissionDenied,
/// unsupported (none of them), corrupt (an empty file; a JPEG whose end is missing, of which its library
/// would make up the rest).
Result<const char*> pictureFormat(const std::filesystem::path& path);

struct Picture {
    storage::Luminance luminance;
    std::vector<std::uint16_t> colors;  ///< linear RGB of each pixel (storage::halfBits); none of a grey one
    std::string colorSpace;             ///< how the file encodes intensity: "sRGB", "linear" or "gamma 2.2"
    bool color = false;                 ///< three channels, of which the luminance is that of ITU-R BT.709
    bool transparent = false;           ///< had an alpha channel
    std::uint64_t invalid = 0;          ///< pixels that are not finite, taken as white
};

/// `memory` in bytes: what reading may take; 0: what the largest picture takes (2^28 pixels). Errors:
/// notFound, permissionDenied, unsupported (another format; deep or solid pictures; a colour space that is
/// not known), corrupt (also a picture without pixels), resourceExhausted (too large: said before memory is
/// taken), cancelled.
Result<Picture> readPicture(const std::filesystem::path& path, std::uint64_t memory, Progress& progress);

}  // namespace mote::prep
