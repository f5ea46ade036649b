// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/particles/usual_range.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

#include "tests/support/beams.h"
#include "tests/support/memory_run.h"

namespace mote::render {
namespace {

using test::MemoryColumns;
using test::MemoryRun;

struct Numbers {
    std::vector<float> values, weights;
};

MemoryRun::Step stepOf(const Numbers& numbers, std::uint64_t seed) {
    const auto points = test::MemoryStep::make(test::evenCloud(numbers.values.size(), seed));
    std::vector<MemoryColumns::Column> columns{{{.name = "q", .unit = "1"}, numbers.values}};
    if (!numbers.weights.empty()) columns.push_back({{.name = "weight", .unit = "1"}, numbers.weights});
    std::vector<std::uint64_t> ids(numbers.values.size());
    auto made = std::make_shared<const MemoryColumns>(numbers.values.size(), std::move(columns), ids);
    return {points, std::move(made)};
}

ValueRange rangeOf(const std::vector<Numbers>& steps) {
    std::vector<MemoryRun::Step> made;
    for (std::size_t i = 0; i < steps.size(); ++i) made.push_back(stepOf(steps[i], i + 1));
    return usualRange(MemoryRun(std::move(made), {}), "q", {}).value();
}

std::vector<float> gaussian(std::size_t count, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<float> value(3.0F, 2.0F);
    std::vector<float> values(count);
    std::ranges::generate(values, [&] { return value(random); });
    return values;
}

TEST(UsualRange, OfFewIsWhatIsCounted) {
    auto all = gaussian(4000, 1);
    const auto range =
        rangeOf({{{all.begin(), all.begin() + 1000}, {}}, {{all.begin() + 1000, all.end()}, {}}});
    std::ranges::sort(all);
    EXPECT_EQ(range.low, static_cast<double>(all[39]));
    EXPECT_EQ(range.high, static_cast<double>(all[3959]));
}

TEST(UsualRange, IsByWeight) {
    // Of the weight, the value -1 has a hundredth less a little, 1 a hundredth and a little more, 0 the rest.
    Numbers numbers;
    for (int i = 0; i < 100; ++i) {
        numbers.values.push_back(i == 0 ? -1.0F : i == 1 ? 1.0F : i == 2 ? 0.5F : 0.0F);
        numbers.weights.push_back(i == 0 ? 9.0F : i == 1 ? 11.0F : 10.0F);
    }
    const auto range = rangeOf({numbers});
    EXPECT_EQ(range.low, 0.0);
    EXPECT_EQ(range.high, 1.0);
}

TEST(UsualRange, IsNotOwnedByOutliers) {
    auto values = gaussian(50000, 2);
    for (std::size_t i = 0; i < 200; ++i) values[250 * i] = i % 2 == 0 ? 1e9F : -1e9F;
    values[7] = std::numeric_limits<float>::quiet_NaN();
    values[8] = std::numeric_limits<float>::infinity();
    const auto range = rangeOf({{values, {}}});
    EXPECT_NEAR(range.low, 3.0 - 2.33 * 2.0, 0.3);
    EXPECT_NEAR(range.high, 3.0 + 2.33 * 2.0, 0.3);
}

TEST(UsualRange, OfMostlyOneValueIsAllThereIs) {
    std::vector<float> values(1000, 5.0F);
    values[3] = 4.0F;
    values[600] = 8.0F;
    const auto range = rangeOf({{values, {}}});
    EXPECT_EQ(range.low, 4.0);
    EXPECT_EQ(range.high, 8.0);
    const auto one = rangeOf({{std::vector<float>(10, 5.0F), {}}});
    EXPECT_EQ(one.low, 5.0);
    EXPECT_EQ(one.high, 5.0);
}

TEST(UsualRange, OfNothingIsZero) {
    const auto none = std::numeric_limits<float>::quiet_NaN();
    const auto range = rangeOf({{{none, none, none}, {}}});
    EXPECT_EQ(range.low, 0.0);
    EXPECT_EQ(range.high, 0.0);
}

TEST(UsualRange, OfManyIsThatOfAnEvenSample) {
    // Values grow along the step, so that a sample of a part of it would be wrong.
    std::vector<float> values(600'000);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i) / 600'000.0F;
    const auto range = rangeOf({{values, {}}});
    EXPECT_NEAR(range.low, 0.01, 0.004);
    EXPECT_NEAR(range.high, 0.99, 0.004);
    const auto again = rangeOf({{values, {}}});
    EXPECT_EQ(again.low, range.low);
    EXPECT_EQ(again.high, range.high);
}

TEST(UsualRange, OfNoSuchColumnIsAnErrorThatNamesIt) {
    const MemoryRun run({stepOf({{1.0F, 2.0F}, {}}, 1)}, {});
    const auto range = usualRange(run, "nothing", {});
    ASSERT_FALSE(range.ok());
    EXPECT_EQ(range.error().where, "column");
    EXPECT_NE(range.error().message.find("nothing"), std::string::npos);
    const auto stopped = usualRange(run, "q", [] { return true; });
    EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace mote::render
