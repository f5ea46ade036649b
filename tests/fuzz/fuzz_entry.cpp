// SPDX-License-Identifier: GPL-3.0-or-later
//
// libFuzzer: NAME-fuzz CORPUS_FOLDER, of the input that MOTE_FUZZ_INPUT names. What it finds is made small
// (-minimize_crash=1) and put into corpus/NAME as bad-WHAT or ok-WHAT.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/inputs.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    mote::test::MOTE_FUZZ_INPUT({reinterpret_cast<const char*>(data), size});
    return 0;
}
