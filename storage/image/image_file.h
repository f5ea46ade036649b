// SPDX-License-Identifier: GPL-3.0-or-later
//
// image.h5 and image.digest of a dataset of kind "image" (docs/FORMAT.md): a picture's luminance on disk, and
// how large it may be. Functions without state; writing has one thread at a time in a process (HDF5), reading
// any.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "storage/files/path_beneath.h"

namespace mote::storage {

/// A grey picture, the linear luminance of each pixel.
struct Luminance {
    std::uint32_t width = 0;    ///< pixels
    std::uint32_t height = 0;   ///< pixels
    std::vector<float> values;  ///< 0 black, 1 white, above 1 in pictures of high range; rows from the top

    float at(std::size_t x, std::size_t y) const { return values[y * width + x]; }
    bool operator==(const Luminance&) const = default;
};

inline constexpr std::uint32_t maxImageSide = 1U << 17;                  ///< pixels
inline constexpr std::uint64_t maxImagePixels = std::uint64_t{1} << 28;  ///< pixels: a GiB of luminance

inline constexpr const char* imageName = "image";

/// Makes both files in `directory`; the picture has at least a pixel. Errors: as writeArrayFile.
Status writeImage(const std::filesystem::path& directory, const Luminance& picture);

/// Reads all of it, every byte held to its digest, the size to the manifest, and every value to be finite and
/// not negative. Errors: notFound, corrupt (with file and array), invalidArgument (a dataset of another
/// kind).
/// One of more than `mostPixels` is averaged down by a whole number.
Result<Luminance> readImage(const PathBeneath& directory, const proto::Manifest& manifest,
                            std::uint64_t mostPixels = maxImagePixels);

}  // namespace mote::storage
