// SPDX-License-Identifier: GPL-3.0-or-later
//
// image.h5 and image.digest of a dataset of kind "image" (docs/FORMAT.md): a picture's luminance and colours
// on disk, and how large it may be. Functions without state; writing has one thread at a time in a process
// (HDF5), reading any.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
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

/// A picture in colour, the light of each pixel.
struct ColorImage {
    std::uint32_t width = 0;   ///< pixels
    std::uint32_t height = 0;  ///< pixels
    /// How many of them the picture is across and down: of the last ones a part may be beyond its edge, where
    /// it was averaged down.
    double columns = 0.0, rows = 0.0;
    std::vector<glm::vec3> values;  ///< linear RGB, finite and not negative; rows from the top

    const glm::vec3& at(std::size_t x, std::size_t y) const { return values[y * width + x]; }
    /// That it takes in memory.
    std::uint64_t bytes() const { return values.capacity() * sizeof(values[0]); }
};

/// The bits of a half float in [0, 65504], the nearest to a light; of less than 0, those of 0.
std::uint16_t halfBits(float light);

inline constexpr std::uint32_t maxImageSide = 1U << 17;                  ///< pixels
inline constexpr std::uint64_t maxImagePixels = std::uint64_t{1} << 28;  ///< pixels: a GiB of luminance

inline constexpr const char* imageName = "image";

/// Makes both files in `directory`; the picture has at least a pixel. `colors`: linear RGB as halfBits, three
/// to a pixel; none of a grey picture. Errors: as writeArrayFile.
Status writeImage(const std::filesystem::path& directory, const Luminance& picture,
                  std::span<const std::uint16_t> colors = {});

/// Reads all of it, every byte held to its digest, the size to the manifest, and every value to be finite and
/// not negative. Errors: notFound, corrupt (with file and array), invalidArgument (a dataset of another
/// kind).
/// One of more than `mostPixels` is averaged down by a whole number.
Result<Luminance> readImage(const PathBeneath& directory, const proto::Manifest& manifest,
                            std::uint64_t mostPixels = maxImagePixels);

/// The same of its colours; a picture without any is grey.
Result<ColorImage> readColors(const PathBeneath& directory, const proto::Manifest& manifest,
                              std::uint64_t mostPixels = maxImagePixels);

}  // namespace mote::storage
