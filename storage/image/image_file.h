// SPDX-License-Identifier: GPL-3.0-or-later
//
// image.h5 and image.digest of a dataset of kind "image" (docs/FORMAT.md): a picture's luminance on disk.
// Functions without state; writing has one thread at a time in a process (HDF5), reading any.
#pragma once

#include <filesystem>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "storage/image/image_limits.h"
#include "storage/image/luminance.h"

namespace mote::storage {

inline constexpr const char* imageName = "image";

/// Makes both files in `directory`; the picture has at least a pixel. Errors: as writeArrayFile.
Status writeImage(const std::filesystem::path& directory, const Luminance& picture);

/// Reads all of it, every byte held to its digest, the size to the manifest, and every value to be finite and
/// not negative. Errors: notFound, corrupt (with file and array), invalidArgument (a dataset of another
/// kind).
/// One of more than `mostPixels` is averaged down by a whole number.
Result<Luminance> readImage(const std::filesystem::path& directory, const proto::Manifest& manifest,
                            std::uint64_t mostPixels = maxImagePixels);

}  // namespace mote::storage
