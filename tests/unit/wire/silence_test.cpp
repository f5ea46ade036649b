// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/wire/silence.h"

#include <gtest/gtest.h>

namespace mote::wire {
namespace {

using namespace std::chrono_literals;
using Verdict = Silence::Verdict;

const Silence::Time start{1h};

TEST(Silence, IsAskedOnceAndThenOver) {
    Silence silence(8s, start);
    EXPECT_EQ(silence.interval(), 1s);
    for (int s = 1; s < 4; ++s) EXPECT_EQ(silence.at(start + s * 1s, 0), Verdict::fine) << s;
    EXPECT_EQ(silence.at(start + 4s, 0), Verdict::ask);
    for (int s = 5; s < 8; ++s) EXPECT_EQ(silence.at(start + s * 1s, 0), Verdict::fine) << s;
    EXPECT_EQ(silence.at(start + 8s, 0), Verdict::gone);
}

TEST(Silence, AnyByteEndsIt) {
    Silence silence(8s, start);
    for (int s = 1; s < 100; ++s) {
        // One byte every seven seconds.
        const auto verdict = silence.at(start + s * 1s, static_cast<std::uint64_t>(s / 7));
        EXPECT_NE(verdict, Verdict::gone) << s;
    }
    EXPECT_EQ(silence.at(start + 100s, 1000), Verdict::fine);
    EXPECT_EQ(silence.at(start + 103s, 1000), Verdict::fine);
    EXPECT_EQ(silence.at(start + 104s, 1000), Verdict::ask) << "asked anew in a new silence";
}

TEST(Silence, OurOwnAbsenceIsNotTheirs) {
    Silence silence(8s, start);
    EXPECT_EQ(silence.at(start + 1h, 0), Verdict::fine);
    EXPECT_EQ(silence.at(start + 1h + 3s, 0), Verdict::fine);
    EXPECT_EQ(silence.at(start + 1h + 4s, 0), Verdict::ask);
    EXPECT_EQ(silence.at(start + 1h + 8s, 0), Verdict::gone);
}

TEST(Silence, WithoutALimitLastsForEver) {
    Silence silence(0s, start);
    EXPECT_EQ(silence.interval(), 0s);
    EXPECT_EQ(silence.at(start + 1000h, 0), Verdict::fine);
}

}  // namespace
}  // namespace mote::wire
