// SPDX-License-Identifier: GPL-3.0-or-later
//
// Kernels of numbers give the same with each kind of vectors that this processor has.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <bit>
#include <cmath>

#include "storage/numbers/bin_axis.h"
#include "storage/numbers/bin_kernel.h"
#include "storage/numbers/chosen_kernel.h"
#include "storage/numbers/range_kernel.h"
#include "tests/support/random.h"

namespace mote::test {
namespace {

/// Lets the process use one kind of vectors alone while it lives.
class OneKind {
  public:
    explicit OneKind(std::int64_t target) { choose(target); }
    ~OneKind() { choose(0); }
    OneKind(const OneKind&) = delete;
    OneKind& operator=(const OneKind&) = delete;

  private:
    static void choose(std::int64_t target) {
        hwy::SetSupportedTargetsForTest(target);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    }
};

/// Floats of all magnitudes, of the edges themselves, and none.
std::vector<float> anyValues(Random& random, double offset, const std::vector<double>& edges) {
    std::vector<float> values(random.oneOf<std::uint64_t>({0, 1, 63, 64, 65, 300, 2000}));
    const double low = edges.front(), high = edges.back(), width = high - low;
    for (auto& value : values) {
        const double place = random.chance(0.3) ? edges[random.below(edges.size())]
                                                : random.between(low - 0.1 * width, high + 0.1 * width);
        value = static_cast<float>(place - offset);
        if (random.chance(0.2)) value = std::nextafter(value, random.chance(0.5) ? -INFINITY : INFINITY);
        if (random.chance(0.05)) value = static_cast<float>(random.sign() * random.magnitude(-30, 30));
        if (random.chance(0.05)) value = random.oneOf({NAN, INFINITY, -INFINITY, 0.0F, -0.0F});
    }
    return values;
}

TEST(AnyVectors, BinsAndRangesAreTheSame) {
    const auto targets = hwy::SupportedAndGeneratedTargets();
    ASSERT_GE(targets.size(), 2U) << "widest first, plain ones last";
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        Random random(seed, 94);
        const double scale = random.magnitude(-12, 12), low = scale * random.between(-1.0, 1.0);
        const auto edges = storage::evenEdges(random.oneOf<std::uint32_t>({1, 2, 7, 100, 512, 4096}), low,
                                              low + scale * random.between(0.1, 3.0));
        const double offset = random.chance(0.5) ? 0.0 : scale * random.between(-10.0, 10.0);
        const auto values = anyValues(random, offset, edges);
        std::vector<std::uint64_t> chosen((values.size() + 63) / 64);
        for (auto& word : chosen) word = random.chance(0.2) ? 0 : random.next();
        const auto range = storage::floatRange(offset, edges[0], edges[edges.size() / 2]);
        for (const auto target : targets) {
            SCOPED_TRACE(testing::Message() << seed << " with " << hwy::TargetName(target));
            const OneKind kind(target);
            std::vector<std::uint32_t> bins(values.size(), 77);
            storage::FloatBins(offset, edges).find(values, bins);
            auto kept = chosen;
            storage::keepInRange(values, range, kept);
            for (std::size_t i = 0; i < values.size(); ++i) {
                const double value = offset + static_cast<double>(values[i]);
                ASSERT_EQ(bins[i], storage::binOf(edges, value)) << value;
                const bool within = value >= edges[0] && value <= edges[edges.size() / 2];
                ASSERT_EQ(kept[i / 64] >> (i % 64) & 1, within ? chosen[i / 64] >> (i % 64) & 1 : 0) << value;
            }
        }
    }
}

TEST(AnyVectors, WhatLiesWithinIsTheSame) {
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
        Random random(seed, 96);
        const auto floats = anyValues(random, 0.0, {-1.0, 0.0, 1.0});
        const std::vector<double> values(floats.begin(), floats.end());
        if (values.empty()) continue;
        const double low = random.oneOf<double>({-INFINITY, -0.5, values[values.size() / 2]});
        const double end = random.oneOf<double>({NAN, 0.5, values[values.size() / 3]});
        for (const auto target : hwy::SupportedAndGeneratedTargets()) {
            SCOPED_TRACE(testing::Message() << seed << " with " << hwy::TargetName(target));
            const OneKind kind(target);
            std::vector<std::uint64_t> words((values.size() + 63) / 64, ~0ULL);
            storage::findWithin(values, low, end, words);
            for (std::size_t i = 0; i < 64 * words.size(); ++i) {
                const bool within = i < values.size() && !(values[i] < low) && !(values[i] >= end);
                ASSERT_EQ(words[i / 64] >> (i % 64) & 1, within ? 1 : 0) << i;
            }
        }
    }
}

TEST(AnyVectors, ChosenValuesAreTheSame) {
    for (std::uint64_t seed = 0; seed < 300; ++seed) {
        Random random(seed, 95);
        const double zero = random.chance(0.3) ? 0.0 : random.between(-10.0, 10.0);
        const auto values = anyValues(random, zero, {-1.0, 0.0, 1.0});
        std::vector<double> wide(values.begin(), values.end());
        std::vector<std::uint64_t> words((values.size() + 63) / 64);
        for (auto& word : words) word = random.oneOf<std::uint64_t>({0, ~0ULL, random.next()});
        if (const auto over = values.size() % 64; over != 0) words.back() &= (1ULL << over) - 1;
        std::vector<double> chosen;
        for (std::size_t i = 0; i < values.size(); ++i) {
            if ((words[i / 64] >> (i % 64) & 1) != 0) chosen.push_back(wide[i]);
        }
        for (const auto target : hwy::SupportedAndGeneratedTargets()) {
            SCOPED_TRACE(testing::Message() << seed << " with " << hwy::TargetName(target));
            const OneKind kind(target);
            std::vector<double> out(chosen.size() + storage::roomBehindChosen + 1, 77.0);
            ASSERT_EQ(storage::copyChosen(values, zero, words, out.data()), chosen.size());
            for (std::size_t i = 0; i < chosen.size(); ++i)
                ASSERT_EQ(std::bit_cast<std::uint64_t>(out[i]),
                          std::bit_cast<std::uint64_t>(zero + chosen[i]));
            EXPECT_EQ(out.back(), 77.0) << "beyond the room";
            ASSERT_EQ(storage::copyChosen(wide, words, out.data()), chosen.size());
            for (std::size_t i = 0; i < chosen.size(); ++i)
                ASSERT_EQ(std::bit_cast<std::uint64_t>(out[i]), std::bit_cast<std::uint64_t>(chosen[i]));
            EXPECT_EQ(out.back(), 77.0) << "beyond the room";
        }
    }
}

}  // namespace
}  // namespace mote::test
