// SPDX-License-Identifier: GPL-3.0-or-later
//
// Datasets of every kind with bytes changed in eight ways and files cut off, the hashes old or made anew.
// With old ones a change is an error, or what is loaded is the same; with new ones it is an error or some
// content, which can be drawn and counted, never a death, and little memory. Of files that are longer than
// that, bytes an even distance apart are changed; tests/reliability/own_files.py changes every byte.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "storage/manifest.h"
#include "storage/verify.h"
#include "tests/unit/damage/damaged_dataset.h"
#include "tests/unit/damage/forged_hashes.h"

namespace mote::test {
namespace {

class ChangedBytes : public testing::TestWithParam<SampleDataset> {
  protected:
    std::vector<Change> changes() const {
        Random random(1, GetParam().name.size());
        return someChangesOf(dataset_.files(), random);
    }
    void print(const char* hashes) const {
        const auto& tally = dataset_.tally();
        fmt::print(
            "{}, {}: {} changes, {} errors, {} the same, {} other; {} of {} questions answered; 0 deaths, at "
            "most "
            "{} MiB\n",
            GetParam().name, hashes, tally.tried, tally.errors, tally.same, tally.other, tally.answers,
            tally.asked, mostMemory());
    }

    DamagedDataset dataset_{GetParam()};
};

TEST_P(ChangedBytes, OfWhatIsIntactEveryQuestionIsAnswered) {
    EXPECT_EQ(dataset_.load(), Outcome::same);
    Random random(3);
    for (std::size_t question = 0; question < dataset_.asker().questions(); ++question) {
        // At rest and in motion, and with and without a bound on memory.
        for (int time = 0; time < 6; ++time) EXPECT_NO_THROW(dataset_.asker().ask(question, random));
    }
}

TEST_P(ChangedBytes, WithOldHashesAreAnErrorOrChangeNothing) {
    for (const auto& change : changes()) {
        dataset_.apply(change);
        const auto outcome = dataset_.load();
        EXPECT_NE(outcome, Outcome::other) << change.text() << ": another picture without an error";
        if (outcome == Outcome::same && change.file != storage::manifestDigestName) {
            EXPECT_FALSE(storage::verifyDataset(dataset_.path()).empty()) << change.text();
        }
        dataset_.restore();
    }
    print("hashes as they were");
    EXPECT_GT(dataset_.tally().errors, 0U);
}

TEST_P(ChangedBytes, WithHashesMadeAnewAreAnErrorOrTheirOwnContent) {
    const auto before = mostMemory();
    Random random(2);
    for (const auto& change : changes()) {
        dataset_.apply(change);
        forgeHashes(dataset_.path());
        dataset_.loadAndAsk(random);
        dataset_.restore();
    }
    print("hashes made anew");
    EXPECT_GT(dataset_.tally().errors, 0U);
    EXPECT_GT(dataset_.tally().answers, 0U);
    // Beyond 64 MiB it is refused. A sanitizer keeps 256 MiB of what was freed.
    EXPECT_LT(mostMemory(), before + 512);
}

INSTANTIATE_TEST_SUITE_P(All, ChangedBytes, testing::ValuesIn(sampleDatasets()),
                         [](const auto& sample) { return sample.param.name; });

}  // namespace
}  // namespace mote::test
