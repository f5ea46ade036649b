// SPDX-License-Identifier: GPL-3.0-or-later
//
// The corpus of the table fuzzer, replayed.
#include "tests/fuzz/corpus_replay.h"
#include "tests/fuzz/table_input.h"

namespace mote::test {
namespace {

TEST(TableCorpus, isReadOrRefusedAsItsNamesSay) {
    expectAsNamed(MOTE_CORPUS "/table", readTable);
}

TEST(TableCorpus, survivesBeingCutAndAltered) {
    readAltered(MOTE_CORPUS "/table", readTable);
}

}  // namespace
}  // namespace mote::test
