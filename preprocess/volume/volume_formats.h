// SPDX-License-Identifier: GPL-3.0-or-later
//
// Readers of volumes that are no stream of numbers: stacks of pictures and OpenVDB. Called from one thread.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/volume/volume_parts.h"
#include "preprocess/volume/volume_source.h"
#include "protocol/scene/error.h"

namespace mote::prep {

// Which files make a stack of pictures, and in which order.

/// Whether an input names several files: a folder, or a name with * or ? that no file has.
bool namesPictures(const std::filesystem::path& input);

/// Its PNG and TIFF files, by their endings, or all files of such names, in natural order. Errors: notFound
/// (none), corrupt (numbers leave one out), resourceExhausted (more than VolumeShape::maxDimension),
/// permissionDenied, internal.
Result<std::vector<std::filesystem::path>> pictureFiles(const std::filesystem::path& input);

/// Orders names in which numbers count as numbers: slice2 before slice10.
bool naturallyLess(std::string_view a, std::string_view b);

// Stacks of pictures: PNG or TIFF files, each a slice, or a TIFF file of several pages. Called from one
// thread.

bool beginsAsPicture(std::string_view bytes);

/// `input` is a folder, a pattern of names (namesPictures) or a TIFF file. Rows from top to bottom are y, the
/// numbers those that the files store: no colour space is undone, no palette looked up. Pictures in colour
/// become their luminance, with a note. `field`: as of chooseParts, of the frames and channels of a file
/// (ImageJ, OME, tifffile), or a channel's name. `progress` is asked while slices are read. Errors: notFound,
/// unsupported (a single picture, another format), corrupt (pictures of different size or type), those of
/// chooseParts, cancelled.
Result<std::unique_ptr<VolumeSource>> openPictureStack(const std::filesystem::path& input,
                                                       const std::string& field, Progress& progress);
Result<VolumeParts> partsOfPictures(const std::filesystem::path& input, const std::string& field,
                                    Progress& progress);

// OpenVDB volumes: one grid of floats, doubles or 32-bit integers, in the box of its active voxels. Called
// from one thread.

bool beginsAsVdb(std::string_view bytes);

/// The grid of the name `field`; "": the first one that can be read. The grid's nodes are in memory, and the
/// voxels of those slices that were asked for last. Errors: notFound (no such grid, none at all), unsupported
/// (vectors, points, a transform that is not linear), corrupt, those of fileStream.
Result<std::unique_ptr<VolumeSource>> openVdb(const std::filesystem::path& path, const std::string& field);

/// All grids, that which is read without a name first. Errors: corrupt, those of fileStream.
Result<std::vector<VolumeField>> vdbFields(const std::filesystem::path& path);

}  // namespace mote::prep
