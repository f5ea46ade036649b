// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <limits>
#include <numeric>

#include "preprocess/particles/bounds_rule.h"

namespace mote::prep {
namespace {

/// The rule on values that lie in one place.
Range robustRange(const std::vector<double>& values) {
    std::vector<double> sample;
    for (std::size_t i = 0; i < values.size(); i += sampleStride(values.size())) sample.push_back(values[i]);
    const Range inside = acceptedRange(sample);
    Range range;
    for (const double value : values) {
        if (inside.contains(value)) range = range.united({value, value});
    }
    return range;
}

TEST(BoundsRule, AllOfAPlainBeam) {
    std::vector<double> values(1001);
    std::iota(values.begin(), values.end(), -500.0);
    EXPECT_EQ(robustRange(values), (Range{-500.0, 500.0}));
}

TEST(BoundsRule, OutliersBeyondAThousandQuartileRanges) {
    std::vector<double> values(1001);
    std::iota(values.begin(), values.end(), 0.0);
    values.push_back(1e30);
    values.push_back(-1e30);
    EXPECT_EQ(robustRange(values), (Range{0.0, 1000.0}));
    // Median 500 and interquartile range close to 501: 400,000 is still beam, 600,000 is not.
    values.push_back(4e5);
    values.push_back(6e5);
    EXPECT_EQ(robustRange(values), (Range{0.0, 4e5}));
}

TEST(BoundsRule, HalfTheSameValueFallsBackToWiderRanges) {
    std::vector<double> values(80, 5.0);
    for (int i = 0; i < 20; ++i) values.push_back(i);
    EXPECT_EQ(robustRange(values), (Range{0.0, 19.0}));
    values.push_back(1e30);  // beyond 1000 times the range from 5 to 95%
    EXPECT_EQ(robustRange(values), (Range{0.0, 19.0}));
    std::vector<double> nearlyAll(10000, 5.0);
    nearlyAll.push_back(7.0);
    EXPECT_EQ(robustRange(nearlyAll), (Range{5.0, 7.0}));
}

TEST(BoundsRule, FewValues) {
    EXPECT_TRUE(robustRange({}).empty());
    EXPECT_EQ(robustRange(std::vector<double>{3.0}), (Range{3.0, 3.0}));
    EXPECT_EQ(robustRange(std::vector<double>{3.0, 1e30}), (Range{3.0, 1e30}));
    const double most = std::numeric_limits<double>::max();
    EXPECT_EQ(robustRange(std::vector<double>{-most, 0.0, most}), (Range{-most, most}));
}

TEST(BoundsRule, OneValueLiesInTheMiddle) {
    for (const double value : {0.0, 5.0, -2e-9, 1e300, 5e-324}) {
        const auto range = widened({value, value});
        ASSERT_TRUE(range.ok());
        EXPECT_LT(range->min, value);
        EXPECT_GT(range->max, value);
        EXPECT_NEAR((value - range->min) / (range->max - range->min), 0.5, 1e-3);
    }
    const double most = std::numeric_limits<double>::max();
    EXPECT_FALSE(widened({-most, most}).ok());
}

}  // namespace
}  // namespace mote::prep
