// SPDX-License-Identifier: GPL-3.0-or-later
//
// The space in which a file says where voxels lie, and how it is brought to that of a scene, so that a
// patient lies at one place whatever the format. Pure functions.
#pragma once

#include <string>
#include <string_view>

#include "preprocess/volume/volume_shape.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// NRRD's name of a space in its long form, "left-posterior-superior" of "LPS" or "LPST"; others in lower
/// case, without the time.
std::string longSpace(std::string_view name);

/// Turns `shape`, whose space is the file's, to `wanted`: "ras" (the default, ""), "lps" or "file". A space
/// that is not a patient's stays, but for a left-handed one, whose mirror image would be seen: its z is
/// turned round, with a note. Errors: invalidArgument (another word).
Status bringTo(std::string_view wanted, VolumeShape& shape);

}  // namespace mote::prep
