// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/golden/golden_strokes.h"

#include "tests/support/random.h"

namespace mote::test {
namespace {

using render::Strokes;

/// A way of a few points from somewhere in the picture or a little beside it.
void addWay(Strokes& strokes, const render::FramePlan& plan, Random& random, std::uint64_t points) {
    double x = random.between(-0.1, 1.1) * plan.width, y = random.between(-0.1, 1.1) * plan.height;
    double width = random.chance(0.2) ? random.between(0.0, 12.0) : random.between(0.0, 2.0);
    const double way = plan.farDepth - plan.nearDepth;
    double depth = plan.nearDepth + random.between(-0.1, 1.1) * way;
    for (std::uint64_t i = 0; i < points; ++i) {
        strokes.points.push_back(
            {static_cast<float>(x), static_cast<float>(y), static_cast<float>(width), depth});
        x += random.between(-12.0, 12.0);
        y += random.between(-12.0, 12.0);
        width = std::max(0.0, width + random.between(-0.5, 0.5));
        depth += random.between(-0.02, 0.02) * way;
    }
}

/// Tiles of some pixels, each at a depth of its own; a few have none.
render::AreaDepths depthsFor(const render::FramePlan& plan, Random& random) {
    constexpr std::uint32_t side = 7;
    render::AreaDepths depths{plan.width, plan.height, {}};
    const std::uint32_t columns = plan.width / side + 1, rows = plan.height / side + 1;
    std::vector<float> tiles(std::size_t{columns} * rows);
    for (auto& depth : tiles) {
        const double share = random.unit();
        depth = random.chance(0.05)
                    ? render::AreaDepths::none
                    : static_cast<float>(plan.nearDepth + share * (plan.farDepth - plan.nearDepth));
    }
    for (std::uint32_t row = 0; row < plan.height; ++row) {
        for (std::uint32_t column = 0; column < plan.width; ++column)
            depths.values.push_back(tiles[std::size_t{row / side} * columns + column / side]);
    }
    return depths;
}

}  // namespace

std::shared_ptr<const Strokes> strokesFor(const render::FramePlan& plan, std::uint64_t seed) {
    Random random(seed);
    auto made = std::make_shared<Strokes>();
    const auto way = [&](std::uint64_t points) {
        const auto begin = static_cast<std::uint32_t>(made->points.size());
        addWay(*made, plan, random, points);
        return render::Stroke{begin, static_cast<std::uint32_t>(made->points.size())};
    };
    for (int i = 0; i < 150; ++i) made->lines.push_back(way(1 + random.below(7)));
    for (int i = 0; i < 12; ++i) {
        const auto begin = static_cast<std::uint32_t>(made->outlines.size());
        for (std::uint64_t left = 1 + random.below(3); left > 0; --left)
            made->outlines.push_back(way(3 + random.below(5)));
        made->areas.push_back({begin, static_cast<std::uint32_t>(made->outlines.size())});
    }
    made->areaDepths = depthsFor(plan, random);
    made->color = {random.unit(), random.unit(), random.unit()};
    return made;
}

void addStrokes(render::FramePlan& plan, std::shared_ptr<const Strokes> strokes, double nearDepth,
                double farDepth) {
    std::vector<render::DepthRange> ranges;
    for (const auto& section : plan.sections)
        ranges.push_back({section.nearDepth, section.farDepth, section.slabs});
    ranges.push_back({nearDepth, farDepth, 0});
    plan.sections = render::depthSections(ranges);
    plan.nearDepth = plan.sections.front().nearDepth;
    plan.farDepth = plan.sections.back().farDepth;
    plan.slabs = plan.sections.back().endSlab();
    plan.strokes.push_back(std::move(strokes));
}

}  // namespace mote::test
