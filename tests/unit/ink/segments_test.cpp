// SPDX-License-Identifier: GPL-3.0-or-later
//
// Regions of generated pictures: their boundaries are where parts differ, and each is one piece.
#include <gtest/gtest.h>
#include <tbb/task_arena.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <limits>
#include <set>

#include "server/render/ink/drawing.h"
#include "server/render/ink/normalised_cut.h"
#include "server/render/ink/region_graph.h"
#include "server/render/ink/segments.h"
#include "server/render/ink/segments_graph.h"
#include "server/render/ink/segments_growing.h"
#include "server/render/ink/show.h"
#include "tests/support/random.h"
#include "tests/unit/ink/ink_views.h"
#include "tests/unit/ink/part_scenes.h"

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

// Each way to part a picture into regions, against scenes whose parts are known, and whatever comes.

constexpr std::array methods{Segmentation::growing, Segmentation::graph, Segmentation::cut,
                             Segmentation::texture};

SegmentOptions by(Segmentation method, std::size_t leastPixels = 36) {
    return {.method = method, .leastPixels = leastPixels};
}

test::PartScene scene(std::uint64_t number, std::uint32_t width, std::uint32_t height, test::Relief relief) {
    test::Random random(number, 1);
    return test::partScene(random, width, height, relief);
}

/// Labels from 0 on, each in use, where anything is seen.
void expectLabels(const Segments& segments, const Modalities& modalities) {
    std::set<std::uint32_t> used;
    for (std::size_t i = 0; i < segments.label.values.size(); ++i) {
        const auto label = segments.label.values[i];
        EXPECT_EQ(label == Segments::nothing, !std::isfinite(modalities.depth.values[i]));
        if (label != Segments::nothing) used.insert(label);
    }
    EXPECT_EQ(used.size(), segments.count);
    EXPECT_TRUE(used.empty() || *used.rbegin() + 1 == segments.count);
}

Segments squares(const Modalities& modalities) {
    Segments made{Raster<std::uint32_t>(modalities.grey.width, modalities.grey.height), 0};
    for (std::uint32_t row = 0; row < modalities.grey.height; ++row) {
        for (std::uint32_t column = 0; column < modalities.grey.width; ++column)
            made.label.at(column, row) = row / 40 * 100 + column / 40;
    }
    return made;
}

double agreement(const Segments& segments, const test::PartScene& scene) {
    return test::compareBoundaries(segments.label, scene.part, 2.0).f();
}

/// The means over 20 scenes are in docs/INK.md; a single scene may have more that is round.
TEST(Segmentations, FindThePartsOfScenes) {
    for (const std::uint64_t number : {1U, 3U}) {
        const auto seen = scene(number, 480, 360, test::Relief::smooth);
        for (const auto method : methods) {
            const double least = method == Segmentation::growing ? 0.8 : 0.9;
            EXPECT_GE(agreement(segmentsOf(seen.modalities, by(method), {}), seen), least)
                << static_cast<int>(method) << ' ' << number;
        }
        EXPECT_LE(agreement(squares(seen.modalities), seen), 0.25) << number;
    }
}

TEST(Segmentations, OnlyTextureTakesRoughSurfacesForOne) {
    const auto seen = scene(5, 480, 360, test::Relief::rough);
    const double texture = agreement(segmentsOf(seen.modalities, by(Segmentation::texture), {}), seen);
    EXPECT_GE(texture, 0.85);
    for (const auto method : {Segmentation::growing, Segmentation::graph, Segmentation::cut})
        EXPECT_LE(agreement(segmentsOf(seen.modalities, by(method), {}), seen), texture - 0.05)
            << static_cast<int>(method);
}

TEST(Segmentations, AreTheSameOnAnyNumberOfThreads) {
    const auto modalities = scene(5, 240, 180, test::Relief::rough).modalities;
    for (const auto method : methods) {
        tbb::task_arena one(1), two(2);
        const auto a = one.execute([&] { return segmentsOf(modalities, by(method), {}); });
        const auto b = two.execute([&] { return segmentsOf(modalities, by(method), {}); });
        EXPECT_EQ(a.label, b.label) << static_cast<int>(method);
        EXPECT_EQ(a.count, b.count);
    }
}

TEST(Segmentations, TakePicturesOfAnySize) {
    for (const auto& [width, height] : {std::pair{1U, 1U}, {1U, 50U}, {50U, 1U}, {2U, 2U}, {3U, 40U}}) {
        const auto modalities = scene(6, width, height, test::Relief::smooth).modalities;
        for (const auto method : methods) {
            for (const std::size_t least : {0U, 1U, 36U, 100000U})
                expectLabels(segmentsOf(modalities, by(method, least), {}), modalities);
        }
    }
}

TEST(Segmentations, TakeNumbersThatAreNone) {
    for (std::uint64_t number = 0; number < 4; ++number) {
        auto modalities = scene(number, 120, 90, test::Relief::rough).modalities;
        test::Random random(number);
        for (auto* const picture : {&modalities.grey, &modalities.angle, &modalities.depth}) {
            for (auto& value : picture->values) {
                if (random.chance(0.1))
                    value = random.oneOf({std::nanf(""), HUGE_VALF, -HUGE_VALF, 3e38F, -3e38F});
            }
        }
        if (number % 2 == 0) modalities.extent = 1e-300;
        for (const auto method : methods) expectLabels(segmentsOf(modalities, by(method), {}), modalities);
    }
}

TEST(Segmentations, AreWhatADrawingAsksFor) {
    const InkScene seen{scene(1, 120, 90, test::Relief::smooth).modalities, {}, {}};
    for (const auto method : methods) {
        auto style = test::usualInk();
        style.show = InkPicture::segments;
        style.hatch.segments = method;
        const auto segments = segmentsOf(seen.modalities, by(method), {});
        EXPECT_EQ(drawInk(seen, style, 1.0, {}).shown, labelPicture(segments.label))
            << static_cast<int>(method);
        for (const auto other : methods) {
            if (other == method) continue;
            EXPECT_NE(segments.label, segmentsOf(seen.modalities, by(other), {}).label)
                << static_cast<int>(other);
        }
    }
}

TEST(Segmentations, LeaveNothingHalfDoneWhereTheyStop) {
    const auto modalities = scene(2, 120, 90, test::Relief::smooth).modalities;
    std::stop_source source;
    source.request_stop();
    for (const auto method : methods) {
        const auto made = segmentsOf(modalities, by(method), source.get_token());
        EXPECT_EQ(made.count, 0U);
        EXPECT_EQ(made.label.values.size(), modalities.depth.values.size());
        for (const auto label : made.label.values) EXPECT_EQ(label, Segments::nothing);
    }
}

/// Crowds of nodes, all of one crowd linked at 1 a pair, and each crowd to the next by one weak link.
RegionGraph crowds(std::uint32_t count, std::uint32_t size, double weak) {
    RegionGraph graph;
    graph.inside.assign(std::size_t{count} * size, 1.0);
    for (std::uint32_t crowd = 0; crowd < count; ++crowd) {
        const std::uint32_t first = crowd * size;
        for (std::uint32_t i = 0; i < size; ++i) {
            for (std::uint32_t k = i + 1; k < size; ++k)
                graph.links.push_back({first + i, first + k, 1.0, 1.0});
        }
        if (crowd + 1 < count) graph.links.push_back({first + size - 1, first + size, weak, 1.0});
    }
    return graph;
}

TEST(NormalisedCuts, PartCrowds) {
    // Eigenvectors are found in two ways, for few nodes and for many.
    for (const auto& [count, size] : {std::pair{2U, 4U}, {5U, 8U}, {20U, 7U}, {40U, 12U}}) {
        const auto groups = normalisedCuts(crowds(count, size, 0.05), {}, {});
        std::set<std::uint32_t> used;
        for (std::size_t i = 0; i < groups.size(); ++i) {
            EXPECT_EQ(groups[i], groups[i / size * size]);
            used.insert(groups[i]);
        }
        EXPECT_EQ(used.size(), count);
        const auto whole = normalisedCuts(crowds(count, size, 1.0), {}, {});
        EXPECT_EQ(std::set<std::uint32_t>(whole.begin(), whole.end()).size(), 1U);
    }
}

TEST(NormalisedCuts, TakeGraphsWithoutLinksOrNodes) {
    EXPECT_TRUE(normalisedCuts({}, {}, {}).empty());
    const auto groups = normalisedCuts({std::vector<double>(300), {}}, {}, {});
    EXPECT_EQ(std::set<std::uint32_t>(groups.begin(), groups.end()).size(), 300U);
    auto chain = crowds(100, 1, 0.0);
    for (auto& node : chain.inside) node = 0.0;
    EXPECT_EQ(normalisedCuts(chain, {}, {}).size(), 100U);
}

/// Pictures of `grey` in columns.
Modalities columnsOf(const std::vector<float>& grey, std::uint32_t rows) {
    const auto width = static_cast<std::uint32_t>(grey.size());
    Modalities made{Raster<float>(width, rows), Raster<float>(width, rows, 5.0F), Raster<float>(width, rows),
                    Raster<std::uint32_t>(width, rows), 10.0};
    for (std::size_t i = 0; i < made.grey.values.size(); ++i) made.grey.values[i] = grey[i % width];
    return made;
}

TEST(GraphSegments, ARampIsOneAndAStepPartsIt) {
    std::vector<float> grey(100);
    for (std::size_t i = 0; i < grey.size(); ++i) grey[i] = 0.008F * static_cast<float>(i);
    EXPECT_EQ(graphSegments(columnsOf(grey, 100), 36, {}).count, 1U);
    for (std::size_t i = 50; i < grey.size(); ++i) grey[i] += 0.2F;
    const auto made = graphSegments(columnsOf(grey, 100), 36, {});
    EXPECT_EQ(made.count, 2U);
    EXPECT_NE(made.label.at(48, 7), made.label.at(51, 7));
}

TEST(Melted, BoundariesWithoutStepsMeltUnlessDirectionsAreApart) {
    auto modalities = columnsOf(std::vector<float>(60, 0.5F), 20);
    Segments thirds{Raster<std::uint32_t>(60, 20), 3};
    for (std::size_t i = 0; i < thirds.label.values.size(); ++i) {
        thirds.label.values[i] = static_cast<std::uint32_t>(i % 60 / 20);
        modalities.angle.values[i] = 0.025F * static_cast<float>(i % 60) + 0.1F;
        if (i % 60 >= 40) modalities.grey.values[i] = 0.9F;
    }
    const auto weights = stepWeights(modalities, {}, {});
    const auto made = melted(thirds, modalities, weights, 0.7, 1.0, {});
    EXPECT_EQ(made.count, 2U);  // directions of the first two are half a radian apart, the third is lighter
    EXPECT_EQ(made.label.at(5, 5), made.label.at(25, 5));
    EXPECT_EQ(melted(thirds, modalities, weights, 0.7, 0.4, {}).count, 3U);
}

}  // namespace
}  // namespace mote::render
