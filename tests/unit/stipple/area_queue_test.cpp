// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/stipple/thinning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace mote::prep {
namespace {

TEST(AreaQueue, GivesTheSmallestWhateverChanges) {
    std::mt19937 random(3);
    std::vector<double> areas(300);
    // Few values, so that there are equals.
    for (auto& area : areas) area = random() % 40;
    AreaQueue queue(areas);
    std::vector<std::uint32_t> left(areas.size());
    for (std::uint32_t i = 0; i < left.size(); ++i) left[i] = i;
    while (!left.empty()) {
        ASSERT_FALSE(queue.empty());
        for (int i = 0; i < 5; ++i) {
            const auto point = left[random() % left.size()];
            areas[point] = random() % 40;
            queue.update(point, areas[point]);
            EXPECT_EQ(queue.area(point), areas[point]);
        }
        const auto smallest = std::min_element(left.begin(), left.end(), [&](auto a, auto b) {
            return areas[a] < areas[b] || (areas[a] == areas[b] && a < b);
        });
        ASSERT_EQ(queue.smallest(), *smallest);
        queue.removeSmallest();
        left.erase(smallest);
    }
    EXPECT_TRUE(queue.empty());
}

}  // namespace
}  // namespace mote::prep
