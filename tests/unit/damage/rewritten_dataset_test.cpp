// SPDX-License-Identifier: GPL-3.0-or-later
//
// Datasets of every kind that are rewritten and cut off in place while they are read, drawn and counted:
// errors are right, and so are pictures; a death is not. tests/reliability/own_files.py asks more.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/unit/damage/rewritten_dataset.h"

namespace mote::test {
namespace {

class RewrittenDataset : public testing::TestWithParam<SampleDataset> {};

TEST_P(RewrittenDataset, IsAnErrorOrAPictureAndInTheEndItself) {
    DamagedDataset dataset(GetParam());
    const auto writes = askWhileRewritten(dataset, 40, 1);
    const auto& tally = dataset.tally();
    fmt::print("{}: {} of {} questions answered, {} changes meanwhile, 0 deaths\n", GetParam().name,
               tally.answers, tally.asked, writes);
    EXPECT_EQ(dataset.load(), Outcome::same);
}

INSTANTIATE_TEST_SUITE_P(All, RewrittenDataset, testing::ValuesIn(sampleDatasets()),
                         [](const auto& sample) { return sample.param.name; });

}  // namespace
}  // namespace mote::test
