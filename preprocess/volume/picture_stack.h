// SPDX-License-Identifier: GPL-3.0-or-later
//
// Stacks of pictures: PNG or TIFF files, each a slice, or a TIFF file of several pages. Called from one
// thread.
#pragma once

#include <filesystem>
#include <string_view>

#include "preprocess/volume/volume_source.h"

namespace mote::prep {

bool beginsAsPicture(std::string_view bytes);

/// `input` is a folder, a pattern of names (namesPictures) or a TIFF file. Rows from top to bottom are y, the
/// numbers those that the files store: no colour space is undone. Pictures in colour become their luminance,
/// with a note. `progress` is asked while slices are read. Errors: notFound, unsupported (a single picture,
/// another format), corrupt (pictures of different size or type), cancelled.
Result<std::unique_ptr<VolumeSource>> openPictureStack(const std::filesystem::path& input,
                                                       Progress& progress);

}  // namespace mote::prep
