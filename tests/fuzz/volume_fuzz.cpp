// SPDX-License-Identifier: GPL-3.0-or-later
//
// libFuzzer: volume-fuzz CORPUS_FOLDER. What it finds is made small (-minimize_crash=1) and put into
// corpus/volume as bad-NAME or ok-NAME.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/volume_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    mote::test::readVolumeInput({reinterpret_cast<const char*>(data), size});
    return 0;
}
