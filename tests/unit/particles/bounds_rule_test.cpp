// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include "preprocess/particles/bounds_rule.h"

namespace mote::prep {
namespace {

/// The rule on values that lie in one place, all of one weight.
Range robustRange(const std::vector<double>& values) {
    std::vector<double> sample;
    for (std::size_t i = 0; i < values.size(); i += sampleStride(values.size())) sample.push_back(values[i]);
    const auto [near, median] = coreOf(sample);
    Range range;
    std::vector<FarValue> below, above;
    for (const double value : values) {
        if (near.contains(value)) range = range.united({value, value});
        if (value < near.min) below.push_back({value, 1.0});
        if (value > near.max) above.push_back({value, 1.0});
    }
    const auto most = mostCut(values.size());
    const auto weight = static_cast<double>(values.size());
    const auto end = [&](std::vector<FarValue>& far, double next, auto further) {
        std::sort(far.begin(), far.end(), [&](auto a, auto b) { return further(a.value, b.value); });
        far.resize(std::min<std::size_t>(far.size(), most + 1));
        const auto cut = cutFrom(far, median, next, weight, most);
        if (cut < far.size()) range = range.united({far[cut].value, far[cut].value});
    };
    const double least = range.min, greatest = range.max;
    end(below, least, std::less<>());
    end(above, greatest, std::greater<>());
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
    // Median 500 and interquartile range close to 501: 600,000 is far, but not by itself.
    values.push_back(4e5);
    values.push_back(6e5);
    EXPECT_EQ(robustRange(values), (Range{0.0, 6e5}));
}

TEST(BoundsRule, HalfTheSameValueFallsBackToWiderRanges) {
    std::vector<double> values(80, 5.0);
    for (int i = 0; i < 20; ++i) values.push_back(i);
    EXPECT_EQ(robustRange(values), (Range{0.0, 19.0}));
    values.push_back(1e30);  // beyond 1000 times the range from 5 to 95%
    EXPECT_EQ(robustRange(values), (Range{0.0, 19.0}));
    values.resize(90);
    values.push_back(1e30);  // more than a hundredth of all
    EXPECT_EQ(robustRange(values).max, 1e30);
    std::vector<double> nearlyAll(10000, 5.0);
    nearlyAll.push_back(7.0);
    EXPECT_EQ(robustRange(nearlyAll), (Range{5.0, 7.0}));
}

TEST(BoundsRule, WhatIsMoreThanATinyShareIsKept) {
    std::vector<double> plasma(5000);
    for (std::size_t i = 0; i < plasma.size(); ++i) plasma[i] = 1e3 * std::sin(static_cast<double>(i));
    for (const std::size_t bunch : {4U, 100U, 900U}) {
        auto values = plasma;
        for (std::size_t i = 0; i < bunch; ++i) values.push_back(1e7 + static_cast<double>(i));
        const double last = values.back();
        EXPECT_EQ(robustRange(values).max, last) << bunch;
        values.push_back(1e30);
        values.push_back(-1e30);
        EXPECT_EQ(robustRange(values).max, last) << bunch;
        EXPECT_GT(robustRange(values).min, -1e30) << bunch;
    }
}

TEST(BoundsRule, AHaloThatThinsOutIsKept) {
    std::vector<double> values;
    for (int i = 1; i < 3000; ++i) values.push_back(std::pow(3000.0 / i, 3.0));
    EXPECT_EQ(robustRange(values).max, 2.7e10);
}

TEST(BoundsRule, FewHeavyOnesAreKept) {
    const std::vector<FarValue> far{{1e9, 2.0}, {9e8, 1.0}};
    EXPECT_EQ(cutFrom(far, 0.0, 5.0, 1000.0, 3), 2U);
    EXPECT_EQ(cutFrom(far, 0.0, 5.0, 290.0, 3), 0U);
    EXPECT_EQ(cutFrom(far, 0.0, 1e8, 1000.0, 3), 0U);
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
