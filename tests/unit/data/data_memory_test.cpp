// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/data_memory.h"

#include <gmock/gmock.h>

namespace mote::server {
namespace {

constexpr std::uint64_t mib = std::uint64_t{1} << 20;

TEST(DataMemory, WhatIsNotForTheServerIsForData) {
    EXPECT_EQ(*dataMemory(512 * mib), 128 * mib);
    EXPECT_EQ(*dataMemory(1024 * mib), 640 * mib);
    EXPECT_EQ(*dataMemory(8192 * mib), 6144 * mib);
}

TEST(DataMemory, NoLimitIsAShareOfTheMachine) {
    EXPECT_GE(*dataMemory(0), 128 * mib);
    for (const std::uint64_t memory : {512, 1024, 8192}) {
        EXPECT_LT(*dataMemory(memory * mib) + pictureMemory(memory * mib), memory * mib);
        EXPECT_GE(pictureMemory(memory * mib), 288 * mib) << "one of 8192 x 4096 and what it becomes";
    }
}

TEST(DataMemory, TooLittleSaysWhatIsNeeded) {
    for (const std::uint64_t memory : {std::uint64_t{1}, 100 * mib, 512 * mib - 1}) {
        const auto refused = dataMemory(memory);
        ASSERT_FALSE(refused.ok());
        EXPECT_EQ(refused.error().code, ErrorCode::invalidArgument);
        EXPECT_THAT(refused.error().message, testing::HasSubstr("--memory 512M at least"));
    }
}

}  // namespace
}  // namespace mote::server
