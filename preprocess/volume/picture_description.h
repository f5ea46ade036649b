// SPDX-License-Identifier: GPL-3.0-or-later
//
// What programs write about a stack into a TIFF file's description: ImageJ's lines, OME's XML, tifffile's
// shape: which page is which slice, channel and frame, and how large voxels are. Texts that nobody vouches
// for. Pure functions.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "preprocess/volume/picture_file.h"
#include "preprocess/volume/volume_parts.h"
#include "protocol/scene/error.h"

namespace mote::prep {

struct StackDescription {
    std::uint64_t channels = 1, slices = 1, frames = 1;
    /// The page of channel c, slice z and frame t is at c + channels (z + slices t); its number in the file.
    std::vector<std::uint32_t> pages;
    std::vector<std::string> channelNames;  ///< none, or of each
    std::uint64_t contiguous = 0;      ///< pictures behind the only page's own, one after the other; 0: none
    double size[3] = {0.0, 0.0, 0.0};  ///< of a voxel along x, y and z; 0: not said
    std::string unit;                  ///< of these
    double frameTime = 0.0;            ///< s; 0: not said
    std::vector<std::string> notes;
};

/// Of a file of so many pages, of which `first` is the head of the first one. Errors, at `where`: corrupt (it
/// tells of other pages than there are), unsupported (pages in other files).
Result<StackDescription> describeStack(const PictureSpec& first, std::size_t pages, const std::string& where);

}  // namespace mote::prep
