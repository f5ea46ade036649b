// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/picture_memory.h"

#include <gtest/gtest.h>

namespace mote::server {
namespace {

constexpr std::uint64_t pictureMib = std::uint64_t{1} << 20;

TEST(PictureMemory, TakesItsOwnAndThenOfWhatIsForData) {
    const auto data = std::make_shared<storage::BlockBudget>(100 * pictureMib);
    const auto memory = std::make_shared<PictureMemory>(116 * pictureMib, data);
    EXPECT_EQ(memory->most(200 * pictureMib), 200 * pictureMib) << "but for what is left to small ones";
    auto large = memory->take(150 * pictureMib);
    ASSERT_TRUE(large);
    EXPECT_EQ(data->resident(), 50 * pictureMib);
    EXPECT_FALSE(memory->take(60 * pictureMib));
    EXPECT_EQ(memory->taken(), 150 * pictureMib);
    EXPECT_TRUE(memory->take(16 * pictureMib)) << "a small one need not wait";
    large->shrink(120 * pictureMib);
    EXPECT_EQ(data->resident(), 20 * pictureMib);
    EXPECT_TRUE(memory->take(60 * pictureMib));
    large->become(10 * pictureMib);
    EXPECT_EQ(large->bytes(), 10 * pictureMib);
    large->become(500 * pictureMib);
    EXPECT_EQ(memory->taken(), 500 * pictureMib);
    EXPECT_FALSE(memory->take(110 * pictureMib)) << "what is there is counted";
    large->become(10 * pictureMib);
    EXPECT_EQ(memory->taken(), 10 * pictureMib);
    large.reset();
    EXPECT_EQ(memory->taken() + data->resident(), 0U);
}

TEST(PictureMemory, DataInUseLeaveNoRoom) {
    const auto data = std::make_shared<storage::BlockBudget>(100 * pictureMib);
    const auto memory = std::make_shared<PictureMemory>(116 * pictureMib, data);
    data->takeAnyway(80 * pictureMib);
    EXPECT_FALSE(memory->take(130 * pictureMib));
    EXPECT_EQ(memory->room(), 120 * pictureMib);
    EXPECT_EQ(memory->taken(), 0U);
    EXPECT_TRUE(memory->take(120 * pictureMib));
}

TEST(PictureMemory, TellsThatSomeWasGivenBack) {
    const auto memory = std::make_shared<PictureMemory>(116 * pictureMib, nullptr);
    int told = 0;
    memory->whenGivenBack([&] { ++told; });
    auto taken = memory->take(64 * pictureMib);
    EXPECT_FALSE(memory->take(64 * pictureMib));
    EXPECT_EQ(told, 0);
    taken->shrink(32 * pictureMib);
    taken.reset();
    EXPECT_EQ(told, 2);
    EXPECT_EQ(memory->givenBack(), 2U);
    taken = memory->take(64 * pictureMib);
    taken->leave();
    EXPECT_EQ(memory->taken(), 0U);
    EXPECT_EQ(told, 2) << "it comes again with its data";
    memory->whenGivenBack({});
    memory->take(pictureMib);
    EXPECT_EQ(told, 2);
}

}  // namespace
}  // namespace mote::server
