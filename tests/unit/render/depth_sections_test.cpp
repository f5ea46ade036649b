// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/depth_sections.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace mote::render {
namespace {

TEST(DepthSections, EmptyDepthHasNone) {
    EXPECT_TRUE(depthSections({}).empty());
    const std::vector<DepthRange> apart{{1.0, 2.0, 16}, {100.0, 300.0, 16}};
    const auto sections = depthSections(apart);
    ASSERT_EQ(sections.size(), 2U);
    EXPECT_EQ(sections[0].nearDepth, 1.0);
    EXPECT_EQ(sections[0].farDepth, 2.0);
    EXPECT_EQ(sections[1].nearDepth, 100.0);
    EXPECT_EQ(sections[1].firstSlab, sections[0].endSlab());
}

/// Ranges of any size within each other: each is cut as finely as it asks for, unless there would be too many
/// slabs, and a place told by the bends is in the slab that its depth has.
TEST(DepthSections, BendsTellTheSlabOfADepth) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> exponent(-3.0, 4.0), share(0.0, 1.0);
    for (int turn = 0; turn < 200; ++turn) {
        std::vector<DepthRange> ranges;
        for (int i = 0; i < 3; ++i) {
            const double near = std::pow(10.0, exponent(random));
            ranges.push_back({near, near + std::pow(10.0, exponent(random)), 192});
        }
        const auto sections = depthSections(ranges);
        ASSERT_FALSE(sections.empty());
        EXPECT_LE(sections.back().endSlab(), mostSlabs);
        for (const auto& range : ranges) {
            const SlabBends bends = slabBends(sections, range.nearDepth, range.farDepth);
            for (int k = 0; k < 50; ++k) {
                const double depth = range.nearDepth + share(random) * (range.farDepth - range.nearDepth);
                const double linear = (depth - bends.first.nearDepth) / bends.first.thickness();
                const double told = bends.first.firstSlab + double{bends(static_cast<float>(linear))};
                const double slab = slabOf(sections, depth);
                // A single-precision number of the range's own length tells no depth better than this.
                const double rounding = 0x1p-23 * linear * bends.first.thickness();
                const double nearer = slabOf(sections, depth - rounding) - 1e-3;
                const double farther = slabOf(sections, depth + rounding) + 1e-3;
                EXPECT_GE(told, nearer * (1.0 - 1e-6)) << turn << ' ' << depth << ' ' << slab;
                EXPECT_LE(told, farther * (1.0 + 1e-6)) << turn << ' ' << depth << ' ' << slab;
            }
        }
    }
}

}  // namespace
}  // namespace mote::render
