// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/stipple/dot_cells.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <glm/geometric.hpp>
#include <random>

namespace mote::render {
namespace {

PixelMap randomMap(std::uint32_t width, std::uint32_t height) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit(0.0F, 0.1F);
    std::vector<float> values(std::size_t{width} * height);
    for (auto& value : values) value = unit(random);
    return {width, height, std::move(values)};
}

std::vector<glm::vec2> randomDots(std::size_t count, float width, float height) {
    std::mt19937 random(9);
    std::uniform_real_distribution<float> unit(-0.05F, 1.05F);  // some lie outside
    std::vector<glm::vec2> dots(count);
    for (auto& dot : dots) dot = {unit(random) * width, unit(random) * height};
    return dots;
}

/// Pixel by pixel, over all dots.
std::vector<DotCell> slowCells(const PixelMap& wanted, const std::vector<glm::vec2>& dots) {
    std::vector<DotCell> cells(dots.size());
    for (std::size_t y = 0; y < wanted.height(); ++y) {
        for (std::size_t x = 0; x < wanted.width(); ++x) {
            const glm::dvec2 pixel(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
            std::size_t nearest = 0;
            for (std::size_t i = 1; i < dots.size(); ++i) {
                if (glm::distance(pixel, glm::dvec2(dots[i])) <
                    glm::distance(pixel, glm::dvec2(dots[nearest]))) {
                    nearest = i;
                }
            }
            cells[nearest].mass += wanted.at(x, y);
            cells[nearest].centroid += static_cast<double>(wanted.at(x, y)) * pixel;
        }
    }
    for (std::size_t i = 0; i < cells.size(); ++i) {
        auto& cell = cells[i];
        cell.centroid = cell.mass > 0.0 ? cell.centroid / cell.mass : glm::dvec2(dots[i]);
    }
    return cells;
}

void expectSameAsSlow(const PixelMap& wanted, const std::vector<glm::vec2>& dots) {
    const auto cells = dotCells(wanted, dots);
    const auto expected = slowCells(wanted, dots);
    for (std::size_t i = 0; i < dots.size(); ++i) {
        // Sums in single precision of at most some 10^4 pixels of a block; a pixel between two dots may be
        // either's, where single and double precision disagree: none is, for these seeds.
        EXPECT_NEAR(cells[i].mass, expected[i].mass, 1e-4 * (1.0 + expected[i].mass)) << i;
        EXPECT_NEAR(cells[i].centroid.x, expected[i].centroid.x, 2e-3) << i;
        EXPECT_NEAR(cells[i].centroid.y, expected[i].centroid.y, 2e-3) << i;
    }
}

TEST(DotCells, areVoronoiCells) {
    expectSameAsSlow(randomMap(131, 77), randomDots(300, 131, 77));
    expectSameAsSlow(randomMap(200, 90), randomDots(3, 200, 90));
    expectSameAsSlow(randomMap(64, 64), randomDots(1, 64, 64));
}

TEST(DotCells, secondMomentsOfARectangle) {
    const PixelMap map(24, 12, std::vector<float>(24 * 12, 0.5F));
    const auto cell = dotCells(map, std::vector<glm::vec2>{{3.0F, 4.0F}}).at(0);
    EXPECT_NEAR(cell.mass, 144.0, 1e-3);
    // Of n pixels' centres in a row: (n^2 - 1) / 12.
    EXPECT_NEAR(cell.xx, (24.0 * 24.0 - 1.0) / 12.0, 1e-2);
    EXPECT_NEAR(cell.yy, (12.0 * 12.0 - 1.0) / 12.0, 1e-2);
    EXPECT_NEAR(cell.xy, 0.0, 1e-2);
}

TEST(DotCells, noDotsAndFarDots) {
    const auto map = randomMap(50, 50);
    EXPECT_TRUE(dotCells(map, {}).empty());
    const auto cells = dotCells(map, std::vector<glm::vec2>{{-1e6F, -1e6F}});
    EXPECT_NEAR(cells.at(0).mass, map.total(), 1e-3);
}

TEST(DotCells, sameOnAnyThreads) {
    const auto map = randomMap(400, 300);
    const auto dots = randomDots(2000, 400, 300);
    const auto all = dotCells(map, dots);
    tbb::task_arena one(1);
    const auto alone = one.execute([&] { return dotCells(map, dots); });
    for (std::size_t i = 0; i < dots.size(); ++i) {
        EXPECT_EQ(all[i].mass, alone[i].mass);
        EXPECT_EQ(all[i].centroid, alone[i].centroid);
    }
}

}  // namespace
}  // namespace mote::render
