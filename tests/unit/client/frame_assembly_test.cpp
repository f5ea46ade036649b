// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/connection_parts.h"

#include <gtest/gtest.h>

namespace mote::client {
namespace {

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
