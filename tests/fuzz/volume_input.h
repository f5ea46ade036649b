// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the fuzzer of the volume readers and the replay of its corpus share. Functions without state.
#pragma once

#include <string>
#include <string_view>

namespace mote::test {

/// Reads `input` as the job would read a file: its first line names the format (auto, nrrd, metaimage, nifti,
/// vti or raw, which stands for 3 x 4 x 5 of i16), the rest is the file, which never touches the disk.
/// Returns the error's sentence, "" where all was read. Aborts where a reader breaks its contract: a shape
/// out of bounds, values that differ when slices are read again.
std::string readVolumeInput(std::string_view input);

}  // namespace mote::test
