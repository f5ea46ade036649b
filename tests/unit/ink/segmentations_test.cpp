// SPDX-License-Identifier: GPL-3.0-or-later
//
// Each way to part a picture into regions, against scenes whose parts are known, and whatever comes.
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <array>
#include <cmath>
#include <set>

#include "server/render/ink/drawing.h"
#include "server/render/ink/normalised_cut.h"
#include "server/render/ink/region_graph.h"
#include "server/render/ink/segments.h"
#include "server/render/ink/segments_graph.h"
#include "server/render/ink/show.h"
#include "tests/support/random.h"
#include "tests/unit/ink/ink_views.h"
#include "tests/unit/ink/part_scenes.h"

namespace mote::render {
namespace {

constexpr std::array ways{Segmentation::growing, Segmentation::graph, Segmentation::cut,
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
        for (const auto method : ways) {
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
    for (const auto method : ways) {
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
        for (const auto method : ways) {
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
        for (const auto method : ways) expectLabels(segmentsOf(modalities, by(method), {}), modalities);
    }
}

TEST(Segmentations, AreWhatADrawingAsksFor) {
    const InkScene seen{scene(1, 120, 90, test::Relief::smooth).modalities, {}, {}};
    for (const auto method : ways) {
        auto style = test::usualInk();
        style.show = InkPicture::segments;
        style.hatch.segments = method;
        const auto segments = segmentsOf(seen.modalities, by(method), {});
        EXPECT_EQ(drawInk(seen, style, 1.0, {}).shown, labelPicture(segments.label))
            << static_cast<int>(method);
        for (const auto other : ways) {
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
    for (const auto method : ways) {
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
