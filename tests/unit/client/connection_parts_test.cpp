// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "client/shared/connection_parts.h"

namespace mote::client {
namespace {

std::string heard(Inbox& inbox, std::string& log) {
    for (auto& entry : inbox.takeAll()) entry.callback();
    return std::exchange(log, {});
}

TEST(InboxTest, NewerNewsOfAStateTakesTheOldersPlaceAtTheEnd) {
    Inbox inbox;
    std::string log;
    const auto say = [&](const char* word) { return [&log, word] { log += word; }; };
    inbox.push("job 1", say("a"));
    inbox.push("", say("b"));
    inbox.push("job 2", say("c"));
    inbox.push("job 1", say("d"));
    inbox.push("", say("e"));
    EXPECT_EQ(heard(inbox, log), "bcde");
    EXPECT_TRUE(inbox.empty());
    EXPECT_EQ(heard(inbox, log), "");
}

TEST(SlidingRateTest, CountsTheLastTwoSecondsOnly) {
    SlidingRate rate;
    const SlidingRate::Time start{};
    const auto at = [&](int ms) { return start + std::chrono::milliseconds(ms); };
    EXPECT_EQ(rate.perSecond(at(0)), 0.0);
    rate.add(at(0), 4.0);
    rate.add(at(0), 2.0);
    rate.add(at(1000), 2.0);
    EXPECT_EQ(rate.perSecond(at(1500)), 4.0);
    EXPECT_EQ(rate.perSecond(at(2500)), 1.0);
    EXPECT_EQ(rate.perSecond(at(3001)), 0.0);
}

using Bytes = std::vector<std::uint8_t>;

proto::Frame piece(std::uint64_t sequence, std::uint64_t begin, std::uint64_t size) {
    proto::Frame message;
    message.set_sequence(sequence);
    message.set_payload_begin(begin);
    message.set_payload_size(size);
    if (begin == 0) message.set_view_id(10 * sequence);
    return message;
}

TEST(FrameAssembly, WholeFramesPassAsTheyAre) {
    FrameAssembly assembly;
    const auto whole = assembly.add(piece(1, 0, 0), Bytes{1, 2});
    ASSERT_TRUE(whole.ok() && *whole);
    EXPECT_EQ((*whole)->payload, (Bytes{1, 2}));
}

TEST(FrameAssembly, PiecesBecomeTheFrame) {
    FrameAssembly assembly;
    EXPECT_FALSE(*assembly.add(piece(1, 0, 5), Bytes{1, 2}));
    EXPECT_FALSE(*assembly.add(piece(1, 2, 0), Bytes{3, 4}));
    const auto whole = assembly.add(piece(1, 4, 0), Bytes{5});
    ASSERT_TRUE(whole.ok() && *whole);
    EXPECT_EQ((*whole)->payload, (Bytes{1, 2, 3, 4, 5}));
    EXPECT_EQ((*whole)->message.view_id(), 10u);
}

TEST(FrameAssembly, AnotherFrameTakesThePlaceOfAnUnfinishedOne) {
    FrameAssembly assembly;
    EXPECT_FALSE(*assembly.add(piece(1, 0, 5), Bytes{1, 2}));
    const auto whole = assembly.add(piece(2, 0, 0), Bytes{9});
    ASSERT_TRUE(whole.ok() && *whole);
    EXPECT_EQ((*whole)->message.sequence(), 2u);
    EXPECT_EQ(assembly.add(piece(1, 2, 0), Bytes{3, 4, 5}).error().code, ErrorCode::corrupt);
}

TEST(FrameAssembly, WhatDoesNotFitIsDamage) {
    FrameAssembly assembly;
    EXPECT_FALSE(assembly.add(piece(1, 2, 0), Bytes{3}).ok());
    EXPECT_FALSE(assembly.add(piece(1, 0, std::uint64_t{1} << 40), Bytes{1}).ok());
    EXPECT_FALSE(*assembly.add(piece(1, 0, 5), Bytes{1, 2}));
    EXPECT_FALSE(assembly.add(piece(1, 3, 0), Bytes{3}).ok());
    EXPECT_FALSE(*assembly.add(piece(2, 0, 3), Bytes{1, 2}));
    EXPECT_FALSE(assembly.add(piece(2, 2, 0), Bytes{3, 4}).ok());
    EXPECT_FALSE(*assembly.add(piece(3, 0, 5), Bytes{1, 2}));
    EXPECT_FALSE(assembly.add(piece(4, 2, 0), Bytes{3, 4, 5}).ok());
}

}  // namespace
}  // namespace mote::client
