// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/playback.h"

#include <gtest/gtest.h>

namespace mote::client {
namespace {

/// Two steps a second, from second 10 on.
Playback playing() {
    Playback playback;
    playback.playing = true;
    playback.stepsPerSecond = 2.0F;
    EXPECT_EQ(playback.next(10.0, 0, 5, true), 1U);
    return playback;
}

TEST(Playback, KeepsToItsRate) {
    auto playback = playing();
    EXPECT_EQ(playback.next(10.25, 1, 5, true), std::nullopt);
    EXPECT_EQ(playback.next(10.5, 1, 5, true), 2U);
}

TEST(Playback, LeavesNoStepOutThatWasNotSeen) {
    auto playback = playing();
    EXPECT_EQ(playback.next(12.0, 1, 5, false), std::nullopt);
    EXPECT_EQ(playback.next(13.0, 1, 5, true), 2U);
    EXPECT_EQ(playback.next(13.25, 2, 5, true), std::nullopt) << "what is late is not made up for";
}

TEST(Playback, BeginsAnewAtTheEnd) {
    auto playback = playing();
    EXPECT_EQ(playback.next(11.0, 4, 5, true), 0U);
}

TEST(Playback, IsStillWhereThereIsNothingToPlay) {
    auto playback = playing();
    EXPECT_EQ(playback.next(20.0, 0, 1, true), std::nullopt);
    EXPECT_EQ(playback.next(20.0, 0, 0, true), std::nullopt);
    playback.playing = false;
    EXPECT_EQ(playback.next(20.0, 0, 5, true), std::nullopt);
}

}  // namespace
}  // namespace mote::client
