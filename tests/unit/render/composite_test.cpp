// SPDX-License-Identifier: GPL-3.0-or-later
//
// The cpu device's composite of points that are put into cells by hand, against closed forms, and the bytes
// of its pixels.
#include "server/render/cpu/composite/composite.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "protocol/scene/srgb.h"
#include "server/render/layers/make_frame_plan.h"
#include "tests/support/memory_step.h"
#include "tests/support/view_text.h"

namespace mote::render {
namespace {

constexpr std::uint32_t slabs = 4;

/// A picture of one pixel with points of one or two layers and no volume.
class CompositeTest : public testing::Test {
  protected:
    explicit CompositeTest(std::size_t layers = 2) {
        auto view = test::viewOf(
            "{'width': 1, 'height': 1, 'background': [0, 0, 1], 'layers': [{'particles': {'volume': "
            "{'curve': "
            "[{'density': 0, 'opacity': 0}]}, 'points': {'opacity': 0.6, 'color': [1, 0, 0]}}}]}");
        view.layers.resize(layers, view.layers.front());
        const auto step = test::MemoryStep::make({{{0.5, 0.5, 0.5}}}, {.volumeLevel = 0, .volume = {0.0F}});
        Quality quality;
        quality.slabs = slabs;
        const auto plan = makeFramePlan({view, std::vector<LayerData>(layers, {.step = step})}, quality);
        frame_ = std::make_unique<CompositeFrame>(plan, PixelFormat::srgb8, std::vector<VisibleField>(),
                                                  FrameColors(plan.points.size()));
        cells_.assign(layers, TileCells(slabs));
    }

    void add(std::size_t layer, std::uint32_t slab, float weight, float place) {
        cells_[layer].touched()[std::size_t{slab} * Tile::packets] = 1;
        PointCell& cell = cells_[layer].cells()[std::size_t{slab} * Tile::pixels];
        cell.weight += weight;
        cell.depth += weight * place;
    }

    std::array<int, 4> pixel() {
        for (auto& cells : cells_) cells.settle();
        std::array<std::uint8_t, 4> bytes{};
        for (auto& cells : cells_) cells.settle();
        compositeTile(*frame_, Tile{0, 0}, cells_, nullptr, bytes.data());
        return {bytes[0], bytes[1], bytes[2], bytes[3]};
    }

    static int encoded(double linear) { return static_cast<int>(std::lround(255.0 * linearToSrgb(linear))); }

    std::unique_ptr<CompositeFrame> frame_;
    std::vector<TileCells> cells_;
};

TEST_F(CompositeTest, NothingIsTheBackground) {
    EXPECT_EQ(pixel(), (std::array<int, 4>{0, 0, 255, 255}));
}

TEST_F(CompositeTest, PointsOfOneLayerDimEachOther) {
    add(0, 1, 1.0F, 0.5F);
    EXPECT_EQ(pixel(), (std::array<int, 4>{encoded(0.6), 0, encoded(0.4), 255}));
    add(0, 1, 1.0F, 0.9F);
    add(0, 3, 1.0F, 0.0F);
    EXPECT_EQ(pixel(), (std::array<int, 4>{encoded(1.0 - 0.064), 0, encoded(0.064), 255}));
}

TEST_F(CompositeTest, SinglePointsOfTwoLayersStandWhereTheyAre) {
    frame_->points[1].color = {0.0F, 1.0F, 0.0F};
    add(0, 2, 1.0F, 0.2F);
    add(1, 2, 1.0F, 0.7F);
    EXPECT_EQ(pixel(), (std::array<int, 4>{encoded(0.6), encoded(0.24), encoded(0.16), 255}));
    cells_[0].clear();
    add(0, 2, 1.0F, 0.8F);
    EXPECT_EQ(pixel(), (std::array<int, 4>{encoded(0.24), encoded(0.6), encoded(0.16), 255}));
    // In slabs of their own the order is that of the slabs.
    cells_[1].clear();
    add(1, 3, 1.0F, 0.0F);
    EXPECT_EQ(pixel(), (std::array<int, 4>{encoded(0.6), encoded(0.24), encoded(0.16), 255}));
}

TEST_F(CompositeTest, ManyPointsAroundTheSameDepthAreMixedEvenly) {
    frame_->points[1].color = {0.0F, 1.0F, 0.0F};
    add(0, 0, 2.0F, 0.5F);
    add(1, 0, 2.0F, 0.5F);
    const double light = 0.5 * (1.0 - std::pow(0.4, 4.0));
    EXPECT_EQ(pixel(),
              (std::array<int, 4>{encoded(light), encoded(light), encoded(std::pow(0.4, 4.0)), 255}));
}

TEST_F(CompositeTest, PixelsAreEncodedToTheNearestStep) {
    // 60 points leave a 1e-24th of what is behind them.
    add(0, 0, 60.0F, 0.5F);
    constexpr int steps = 30000;
    for (int i = 0; i < steps; i += 3) {
        const std::array<float, 3> linear{static_cast<float>(i) / steps, static_cast<float>(i + 1) / steps,
                                          static_cast<float>(i + 2) / steps};
        frame_->points[0].color = {linear[0], linear[1], linear[2]};
        const auto bytes = pixel();
        for (std::size_t c = 0; c < 3; ++c) {
            // 0.0025 of the polynomial and some roundings of single precision at 255.
            ASSERT_NEAR(bytes[c], 255.0 * linearToSrgb(linear[c]), 0.5 + 0.003) << linear[c];
        }
    }
}

}  // namespace
}  // namespace mote::render
