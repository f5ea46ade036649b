// SPDX-License-Identifier: GPL-3.0-or-later
//
// Regions of generated pictures: their boundaries are where parts differ, and each is one piece.
#include "server/render/ink/segments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <limits>
#include <set>

#include "server/render/ink/segments_growing.h"
#include "tests/support/random.h"

namespace mote::render {
namespace {

constexpr std::uint32_t segmentsSide = 96;

Modalities blank(double extent = 10.0) {
    return {Raster<float>(segmentsSide, segmentsSide, 0.5F), Raster<float>(segmentsSide, segmentsSide, 5.0F),
            Raster<float>(segmentsSide, segmentsSide), Raster<std::uint32_t>(segmentsSide, segmentsSide, 0U),
            extent};
}

/// Parts around middles, each with grey, direction and depth that differ from every other's in one of these
/// at least; noise, and a slope in depth under all of them. Part 0 is nothing where `holes`.
Modalities parted(test::Random& random, std::uint32_t parts, bool holes, Raster<std::uint32_t>& part) {
    auto made = blank();
    part = Raster<std::uint32_t>(segmentsSide, segmentsSide);
    std::vector<glm::dvec2> middles;
    while (middles.size() < parts) {
        const glm::dvec2 at(random.between(0.0, segmentsSide), random.between(0.0, segmentsSide));
        if (std::all_of(middles.begin(), middles.end(),
                        [&](auto& one) { return glm::distance(one, at) > 18.0; }))
            middles.push_back(at);
    }
    const glm::dvec2 slope(random.between(-0.3, 0.3), random.between(-0.3, 0.3));
    for (std::uint32_t row = 0; row < segmentsSide; ++row) {
        for (std::uint32_t column = 0; column < segmentsSide; ++column) {
            const glm::dvec2 at(column, row);
            std::uint32_t nearest = 0;
            for (std::uint32_t i = 1; i < parts; ++i) {
                if (glm::distance(at, middles[i]) < glm::distance(at, middles[nearest])) nearest = i;
            }
            part.at(column, row) = nearest;
            const auto i = made.grey.index(column, row);
            made.grey.values[i] =
                static_cast<float>(0.1 + 0.27 * (nearest % 4) + random.between(-0.04, 0.04));
            made.angle.values[i] =
                static_cast<float>(0.3 + 1.5 * (nearest / 4 % 2) + random.between(-0.1, 0.1));
            made.depth.values[i] = static_cast<float>(glm::dot(slope, at) + nearest / 8);
            if (!holes || nearest > 0) continue;
            made.depth.values[i] = HUGE_VALF;
            made.part.values[i] = Modalities::nothing;
            made.grey.values[i] = 1.0F;
            made.angle.values[i] = 0.0F;
        }
    }
    return made;
}

/// Pixels whose right or lower neighbour has another label.
std::vector<glm::dvec2> boundaryOf(const Raster<std::uint32_t>& label) {
    std::vector<glm::dvec2> pixels;
    for (std::uint32_t row = 0; row + 1 < segmentsSide; ++row) {
        for (std::uint32_t column = 0; column + 1 < segmentsSide; ++column) {
            const auto own = label.at(column, row);
            if (own != label.at(column + 1, row) || own != label.at(column, row + 1))
                pixels.emplace_back(column, row);
        }
    }
    return pixels;
}

double shareNear(const std::vector<glm::dvec2>& some, const std::vector<glm::dvec2>& others) {
    const auto near = std::count_if(some.begin(), some.end(), [&](const auto& one) {
        return std::any_of(others.begin(), others.end(),
                           [&](auto& two) { return glm::distance(one, two) <= 2.0; });
    });
    return static_cast<double>(near) / static_cast<double>(some.size());
}

/// How many pixels of a label are connected with its first one.
std::vector<std::size_t> expectPartition(const Segments& segments, const Modalities& modalities) {
    std::vector<std::size_t> pixels(segments.count), connected(segments.count);
    const auto& labels = segments.label.values;
    std::vector<bool> reached(labels.size());
    for (std::size_t i = 0; i < labels.size(); ++i) {
        EXPECT_EQ(labels[i] == Segments::nothing, !std::isfinite(modalities.depth.values[i]));
        if (labels[i] == Segments::nothing) continue;
        EXPECT_LT(labels[i], segments.count);
        if (pixels[labels[i]]++ > 0) continue;
        std::vector<std::size_t> front{i};
        reached[i] = true;
        while (!front.empty()) {
            const auto at = front.back();
            front.pop_back();
            ++connected[labels[i]];
            const auto go = [&](bool there, std::size_t to) {
                if (!there || reached[to] || labels[to] != labels[i]) return;
                reached[to] = true;
                front.push_back(to);
            };
            go(at % segmentsSide > 0, at - 1);
            go(at % segmentsSide + 1 < segmentsSide, at + 1);
            go(at >= segmentsSide, at - segmentsSide);
            go(at + segmentsSide < labels.size(), at + segmentsSide);
        }
    }
    EXPECT_EQ(pixels, connected);
    for (const auto count : pixels) EXPECT_GT(count, 0U);
    return pixels;
}

/// Whether any pixel of another region is beside one of this.
bool hasNeighbour(const Segments& segments, std::uint32_t label) {
    const auto& labels = segments.label;
    const auto meets = [&](std::uint32_t a, std::uint32_t b) {
        return a != b && (a == label || b == label) && a != Segments::nothing && b != Segments::nothing;
    };
    for (std::uint32_t row = 0; row < segmentsSide; ++row) {
        for (std::uint32_t column = 0; column < segmentsSide; ++column) {
            const auto own = labels.at(column, row);
            if (column + 1 < segmentsSide && meets(own, labels.at(column + 1, row))) return true;
            if (row + 1 < segmentsSide && meets(own, labels.at(column, row + 1))) return true;
        }
    }
    return false;
}

TEST(Segments, EndWherePartsDiffer) {
    test::Random random(6);
    double sum = 0.0, least = 1.0;
    constexpr int pictures = 30;
    for (int i = 0; i < pictures; ++i) {
        Raster<std::uint32_t> part;
        const auto modalities = parted(random, static_cast<std::uint32_t>(2 + i % 11), i % 3 == 0, part);
        const auto segments = segmentsOf(modalities, {}, {});
        const auto sizes = expectPartition(segments, modalities);
        for (std::uint32_t label = 0; label < sizes.size(); ++label)
            EXPECT_TRUE(sizes[label] >= 36 || !hasNeighbour(segments, label));
        const auto wanted = boundaryOf(part), found = boundaryOf(segments.label);
        const double precision = shareNear(found, wanted), recall = shareNear(wanted, found);
        const double measure = 2.0 * precision * recall / (precision + recall);
        EXPECT_GE(measure, 0.9) << i << ": " << precision << ' ' << recall;
        sum += measure;
        least = std::min(least, measure);
    }
}

TEST(Segments, ASlopeIsOneAndAStepPartsIt) {
    for (const float slope : {0.0F, 0.05F, 1.0F, 30.0F}) {
        auto modalities = blank();
        for (std::uint32_t i = 0; i < segmentsSide * segmentsSide; ++i)
            modalities.depth.values[i] = slope * (i % segmentsSide + i / segmentsSide);
        EXPECT_EQ(growDepth(modalities, 0.01, {}).count, 1U) << slope;
        for (std::uint32_t i = 0; i < segmentsSide * segmentsSide; ++i) {
            if (i % segmentsSide >= 40) modalities.depth.values[i] += 5.0F;
        }
        const auto made = growDepth(modalities, 0.01, {});
        EXPECT_EQ(made.count, 2U) << slope;
        EXPECT_NE(made.label.at(39, 50), made.label.at(40, 50));
    }
}

TEST(Segments, DirectionsHaveNoSign) {
    auto modalities = blank();
    for (std::uint32_t i = 0; i < segmentsSide * segmentsSide; ++i)
        modalities.angle.values[i] = i % 2 == 0 ? 1.0F : 1.0F - 3.14159F;
    EXPECT_EQ(growAngle(modalities, 0.1, {}).count, 1U);
    for (std::uint32_t i = 0; i < segmentsSide * segmentsSide; ++i)
        modalities.angle.values[i] = i / segmentsSide < 30 ? 0.5F : 2.0F;
    EXPECT_EQ(growAngle(modalities, 0.6, {}).count, 2U);
}

TEST(Segments, NumbersThatAreNoneDoNoHarm) {
    test::Random random(7);
    for (int i = 0; i < 12; ++i) {
        Raster<std::uint32_t> part;
        auto modalities = parted(random, 6, i % 2 == 0, part);
        for (auto* const picture : {&modalities.grey, &modalities.angle, &modalities.depth}) {
            for (auto& value : picture->values) {
                if (random.chance(0.05))
                    value = random.oneOf({std::nanf(""), HUGE_VALF, -HUGE_VALF, 3e38F, -3e38F});
            }
        }
        if (i % 4 == 0) modalities.extent = 1e-300;
        expectPartition(segmentsOf(modalities, {}, {}), modalities);
    }
    auto nothing = blank();
    for (auto& depth : nothing.depth.values) depth = HUGE_VALF;
    EXPECT_EQ(segmentsOf(nothing, {}, {}).count, 0U);
}

TEST(Segments, TheLargestLeastLeavesOneOfEachIsland) {
    test::Random random(8);
    Raster<std::uint32_t> part;
    const auto modalities = parted(random, 9, false, part);
    SegmentOptions options;
    options.leastPixels = std::size_t{segmentsSide} * segmentsSide;
    EXPECT_EQ(segmentsOf(modalities, options, {}).count, 1U);
}

}  // namespace
}  // namespace mote::render
