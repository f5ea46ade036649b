// SPDX-License-Identifier: GPL-3.0-or-later
//
// Turns a picture the way its file says it is to be seen: cameras store it as the sensor lay. Pure.
#pragma once

#include "storage/image/luminance.h"

namespace mote::prep {

/// `orientation` as in Exif and TIFF (tag 274), 1 to 8; the picture as it is for 1 and for other numbers.
storage::Luminance upright(storage::Luminance picture, int orientation);

}  // namespace mote::prep
