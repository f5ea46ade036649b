// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/memory_reserve.h"

#include <gtest/gtest.h>

#include <new>

namespace mote::server {
namespace {

TEST(MemoryReserve, IsGivenBackOnceWhereMemoryIsShortAndKeptAgain) {
    const auto before = std::get_new_handler();
    for (int turn = 0; turn < 2; ++turn) {
        ASSERT_TRUE(keepMemoryReserve());
        ASSERT_TRUE(keepMemoryReserve());  // which is no second one
        const auto find = std::get_new_handler();
        EXPECT_NO_THROW(find());
        EXPECT_THROW(find(), std::bad_alloc);
    }
    std::set_new_handler(before);
}

}  // namespace
}  // namespace mote::server
