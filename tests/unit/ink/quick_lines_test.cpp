// SPDX-License-Identifier: GPL-3.0-or-later
//
// Lines of pictures in motion, against those of pictures at rest.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "server/render/ink/choose_lines.h"
#include "server/render/ink/complexity.h"
#include "server/render/layers/ink/mesh_lines.h"
#include "server/render/layers/ink/mesh_modalities.h"
#include "tests/support/generated_mesh.h"
#include "tests/unit/ink/ink_views.h"

namespace mote::render {
namespace {

constexpr std::uint32_t quickSide = 240;

struct Seen {
    Modalities modalities;
    std::vector<InkLine> quick, exact;
};

Seen seenOf(const MeshSurface& surface, const Camera& camera) {
    auto plan = test::planOf(camera, quickSide, quickSide);
    const LineView view(plan, glm::dmat4(1.0));
    const auto edges = linesOf(surface, view, 60.0, {});
    const auto still = modalitiesOf(surface, glm::dmat4(1.0), test::usualInk(), plan, {});
    const auto pieces = visible(surface, view, edges, {.sampling = 0.35}, {});
    plan.exact = false;
    auto moving = modalitiesOf(surface, glm::dmat4(1.0), test::usualInk(), plan, {});
    Seen seen{std::move(moving.modalities), {}, {}};
    seen.quick = quickLines(surface, view, edges, seen.modalities, {});
    seen.exact = chained(surface, view, pieces, still.modalities.extent, {});
    return seen;
}

TEST(QuickLines, LieWhereTheExactOnesDo) {
    for (const auto form : test::meshForms()) {
        test::Random random(3);
        const auto surface = test::meshOf(std::string(form), 1, 200);
        double off = 0.0, all = 0.0;
        for (int i = 0; i < 4; ++i) {
            Camera camera;
            const Bounds& bounds = surface->bounds();
            camera.target = bounds.center();
            camera.eye = camera.target + 2.0 * glm::length(bounds.size()) * random.direction();
            camera.up = random.direction();
            camera.fovYDegrees = 35.0;
            const auto seen = seenOf(*surface, camera);
            const auto quick = blurred(coverOf(seen.quick, quickSide, quickSide, 1.2), 3.0);
            const auto exact = blurred(coverOf(seen.exact, quickSide, quickSide, 1.2), 3.0);
            for (std::size_t k = 0; k < quick.values.size(); ++k) {
                off += static_cast<double>(std::abs(quick.values[k] - exact.values[k]));
                all += static_cast<double>(exact.values[k]);
            }
        }
        EXPECT_LT(off, 0.35 * all + 1.0) << form;
    }
}

/// Lines everywhere in a square, all alike.
std::vector<InkLine> crowd(std::size_t count) {
    test::Random random(5);
    std::vector<InkLine> lines;
    for (std::size_t i = 0; i < count; ++i) {
        const glm::dvec2 at(random.between(4.0, quickSide - 4.0), random.between(4.0, quickSide - 4.0));
        const double angle = random.between(0.0, 3.0);
        const glm::dvec2 way = 3.0 * glm::dvec2(std::cos(angle), std::sin(angle));
        lines.push_back({LineKind::border,
                         {{at, 1.0, 0.0}, {at + way, 1.0, 0.0}},
                         static_cast<float>(random.between(0.0, 1.0))});
    }
    return lines;
}

TEST(QuickLines, ACrowdIsThinnedOutToTheTone) {
    const auto lines = crowd(20000);
    const ToneCells cells(quickSide, quickSide, 6.0);
    for (const float tone : {0.1F, 0.3F, 0.5F}) {
        const ToneGrid target(cells.columns, cells.rows, tone);
        const auto chosen =
            chooseLines(lines, test::usualInk().silhouettes, {cells, target, 1.0, 12.0, true}, {});
        EXPECT_EQ(chosen.lines.size() + chosen.left.size(), lines.size());
        double mean = 0.0, count = 0.0;
        for (std::uint32_t row = cells.rows / 4; row < 3 * cells.rows / 4; ++row) {
            for (std::uint32_t column = cells.columns / 4; column < 3 * cells.columns / 4; ++column) {
                mean += 1.0 - std::exp(-static_cast<double>(chosen.density.at(column, row)));
                count += 1.0;
            }
        }
        EXPECT_NEAR(mean / count, tone, 0.03);
    }
}

TEST(QuickLines, LinesThatAreDrawnStayAsItGrowsDarker) {
    const auto lines = crowd(5000);
    const ToneCells cells(quickSide, quickSide, 6.0);
    std::set<std::pair<double, double>> before;
    for (const float tone : {0.05F, 0.1F, 0.2F}) {
        const ToneGrid target(cells.columns, cells.rows, tone);
        std::set<std::pair<double, double>> drawn;
        for (const auto& line :
             chooseLines(lines, test::usualInk().silhouettes, {cells, target, 1.0, 12.0, true}, {}).lines)
            drawn.emplace(line.points[0].at.x, line.points[0].at.y);
        EXPECT_TRUE(std::includes(drawn.begin(), drawn.end(), before.begin(), before.end()));
        EXPECT_GT(drawn.size(), before.size());
        before = drawn;
    }
}

}  // namespace
}  // namespace mote::render
