// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/stipple/photograph.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <set>
#include <tuple>

#include "server/render/layers/stipple/dot_cells.h"
#include "server/render/layers/stipple/photograph_dots.h"
#include "tests/unit/stipple/small_hierarchy.h"

namespace mote::render {
namespace {

constexpr std::uint32_t side = 240;
constexpr double full = 0.05;  // dots a square pixel

/// From nothing at the left edge to the full density at the right one, and white below.
PixelMap ramp() {
    std::vector<float> values(std::size_t{side} * side);
    for (std::size_t i = 0; i < values.size(); ++i) {
        const bool white = i / side >= 200;
        values[i] = white ? 0.0F : static_cast<float>(full * static_cast<double>(i % side) / side);
    }
    return {side, side, std::move(values)};
}

class PhotographTest : public ::testing::Test {
  protected:
    std::vector<TileDot> dotsOf(const PixelMap& wanted, const PhotographEffort& effort) const {
        return stipplePhotograph(tiles_, wanted, {full}, effort);
    }

    /// Root mean square of how far cells are from holding one dot.
    double unevenness(const PixelMap& wanted, const std::vector<TileDot>& dots) const {
        std::vector<glm::vec2> places;
        for (const auto& dot : dots) places.push_back(dot.place);
        double sum = 0.0;
        for (const auto& cell : dotCells(wanted, places)) sum += (cell.mass - 1.0) * (cell.mass - 1.0);
        return std::sqrt(sum / static_cast<double>(dots.size()));
    }

    PlaneTiles tiles_{std::make_shared<const storage::StippleHierarchy>(test::jitteredGrid(60))};
};

/// Each dot that is drawn or left out wrongly counts one way or the other: of N independent ones 4 sqrt(N) is
/// four standard deviations, and neither selection nor balance is worse than chance.
TEST_F(PhotographTest, countsAreTheTone) {
    const auto wanted = ramp();
    const double total = wanted.total();
    const auto quick = dotsOf(wanted, quickPhotograph);
    EXPECT_NEAR(static_cast<double>(quick.size()), total, 4.0 * std::sqrt(total));
    const auto fine = dotsOf(wanted, finePhotograph);
    EXPECT_NEAR(static_cast<double>(fine.size()), total, 4.0 * std::sqrt(total));
}

TEST_F(PhotographTest, effortMakesCellsEven) {
    const auto wanted = ramp();
    const double plain = unevenness(wanted, dotsOf(wanted, {false, 0}));
    const double fine = unevenness(wanted, dotsOf(wanted, finePhotograph));
    EXPECT_LT(fine, 0.6 * plain);
}

TEST_F(PhotographTest, dotsLieInsideAndWhereInkIs) {
    const auto wanted = ramp();
    for (const auto& effort : {PhotographEffort{false, 0}, quickPhotograph, finePhotograph}) {
        std::set<std::tuple<int, int, std::uint32_t>> seen;
        for (const auto& dot : dotsOf(wanted, effort)) {
            EXPECT_TRUE(seen.emplace(dot.column, dot.row, dot.point).second);  // each point is one dot
            EXPECT_GE(dot.place.x, 0.0F);
            EXPECT_LT(dot.place.x, static_cast<float>(side));
            EXPECT_GE(dot.place.y, 0.0F);
            // Cells at the edge are some spacings large where the ramp begins: 4 / sqrt(0.01).
            EXPECT_LT(dot.place.y, 240.0F);
        }
    }
}

TEST_F(PhotographTest, whiteAndBlackAndTiny) {
    const auto even = [](std::uint32_t size, double density) {
        return PixelMap(size, size,
                        std::vector<float>(std::size_t{size} * size, static_cast<float>(density)));
    };
    EXPECT_TRUE(dotsOf(even(50, 0.0), finePhotograph).empty());
    EXPECT_NEAR(static_cast<double>(dotsOf(even(200, full), finePhotograph).size()), 2000.0, 60.0);
    EXPECT_LE(dotsOf(even(1, full), finePhotograph).size(), 1u);
    EXPECT_LE(dotsOf(even(3, 1e-30), finePhotograph).size(), 1u);
}

TEST_F(PhotographTest, sameOnAnyThreads) {
    const auto wanted = ramp();
    const auto all = dotsOf(wanted, finePhotograph);
    tbb::task_arena one(1);
    const auto alone = one.execute([&] { return dotsOf(wanted, finePhotograph); });
    ASSERT_EQ(all.size(), alone.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
        EXPECT_EQ(all[i].place, alone[i].place);
        EXPECT_EQ(all[i].point, alone[i].point);
    }
}

TEST_F(PhotographTest, luminanceOfAPicture) {
    const Picture picture{2, 1, PixelFormat::srgb8, {255, 0, 0, 255, 255, 255, 255, 255}, 0};
    const auto luminance = luminanceOf(picture);
    EXPECT_FLOAT_EQ(luminance.at(0, 0), 0.2126F);
    EXPECT_NEAR(luminance.at(1, 0), 1.0, 1e-6);
}

}  // namespace
}  // namespace mote::render
