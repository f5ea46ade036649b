// SPDX-License-Identifier: GPL-3.0-or-later
//
// The corpus of the volume fuzzer, replayed.
#include "tests/fuzz/corpus_replay.h"
#include "tests/fuzz/volume_input.h"

namespace mote::test {
namespace {

TEST(VolumeCorpus, isReadOrRefusedAsItsNamesSay) {
    expectAsNamed(MOTE_CORPUS "/volume", readVolumeInput);
}

TEST(VolumeCorpus, survivesBeingCutAndAltered) {
    readAltered(MOTE_CORPUS "/volume", readVolumeInput);
}

}  // namespace
}  // namespace mote::test
