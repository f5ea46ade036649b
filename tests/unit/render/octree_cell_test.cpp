// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/octree_cell.h"

#include <gtest/gtest.h>

#include <random>

namespace mote::render {
namespace {

/// Bit by bit, as the format says: x in bit 0, y in bit 1, z in bit 2.
std::uint64_t mortonOf(const glm::uvec3& place) {
    std::uint64_t code = 0;
    for (int bit = 0; bit < deepestLevel; ++bit) {
        for (int axis = 0; axis < 3; ++axis)
            code |= std::uint64_t{(place[axis] >> bit) & 1U} << (3 * bit + axis);
    }
    return code;
}

TEST(OctreeCell, TakesMortonCodesApart) {
    constexpr std::uint32_t last = (1U << deepestLevel) - 1;
    EXPECT_EQ(cellPlace(0), glm::uvec3(0));
    EXPECT_EQ(cellPlace(mortonOf({last, 0, 0})), glm::uvec3(last, 0, 0));
    EXPECT_EQ(cellPlace(mortonOf({0, last, 0})), glm::uvec3(0, last, 0));
    EXPECT_EQ(cellPlace(mortonOf({0, 0, last})), glm::uvec3(0, 0, last));
    std::mt19937 random(7);
    for (int i = 0; i < 1000; ++i) {
        const glm::uvec3 place(random() & last, random() & last, random() & last);
        EXPECT_EQ(cellPlace(mortonOf(place)), place);
    }
}

}  // namespace
}  // namespace mote::render
