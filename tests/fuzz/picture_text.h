// SPDX-License-Identifier: GPL-3.0-or-later
//
// Pictures from a line of text, written by OpenImageIO. A function without state.
//
//   NAME.png WIDTH HEIGHT CHANNELS TYPE [tiled] [alpha] [bits=N] [pages=N] [cut=BYTES]     or NAME.tif
//   NAME TEXT                                                                 of other names than those
#pragma once

#include <string_view>

#include "tests/fuzz/input_folder.h"

namespace mote::test {

/// What the format cannot hold is left out.
void writePicture(const InputFolder& folder, std::string_view line);

}  // namespace mote::test
