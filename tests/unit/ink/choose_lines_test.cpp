// SPDX-License-Identifier: GPL-3.0-or-later
//
// The choice of lines: the tone that is drawn, blurred by a plain Gaussian, meets its target; what must be
// drawn is; the order of lines does not matter.
#include "server/render/ink/choose_lines.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "server/render/ink/tone_grid.h"
#include "tests/support/random.h"
#include "tests/unit/ink/ink_cover.h"
#include "tests/unit/ink/ink_views.h"

namespace mote::render {
namespace {

constexpr std::uint32_t columns = 192, rows = 144;
constexpr double reading = 6.0, lineWidth = 1.2;

/// Straight, of points some pixels apart, each with a step of its own of at most `most`.
InkLine anyLine(test::Random& random, double most) {
    InkLine line;
    const glm::dvec2 from(random.between(-20.0, columns + 20.0), random.between(-20.0, rows + 20.0));
    const double angle = random.between(0.0, 6.3);
    const auto count = 8 + random.below(20);
    for (std::uint64_t i = 0; i < count; ++i) {
        const glm::dvec2 at =
            from + 5.0 * static_cast<double>(i) * glm::dvec2(std::cos(angle), std::sin(angle));
        line.points.push_back({at, 1.0, most * random.unit()});
    }
    return line;
}

std::vector<InkLine> manyLines(test::Random& random, std::size_t count, double most) {
    std::vector<InkLine> lines;
    while (lines.size() < count) lines.push_back(anyLine(random, most));
    return lines;
}

struct Target {
    ToneCells cells{columns, rows, reading};
    ToneGrid grid;

    explicit Target(double tone) : grid(cells.columns, cells.rows, static_cast<float>(tone)) {}
    ChosenLines chosen(const std::vector<InkLine>& lines, const SilhouetteStyle& style) const {
        return chooseLines(lines, style, {cells, grid, lineWidth, 2.0 * reading}, {});
    }
};

/// By a Gaussian as it stands in books.
Raster<double> plainlyBlurred(const Raster<double>& picture, double deviation) {
    const int reach = static_cast<int>(4.0 * deviation);
    Raster<double> across(picture.width, picture.height), made = across;
    const auto pass = [&](const Raster<double>& from, Raster<double>& to, bool sideways) {
        for (std::uint32_t row = 0; row < from.height; ++row) {
            for (std::uint32_t column = 0; column < from.width; ++column) {
                double sum = 0.0, weights = 0.0;
                for (int i = -reach; i <= reach; ++i) {
                    const double weight = std::exp(-0.5 * i * i / (deviation * deviation));
                    sum += weight * from.near(column + (sideways ? i : 0), row + (sideways ? 0 : i));
                    weights += weight;
                }
                to.at(column, row) = sum / weights;
            }
        }
    };
    pass(picture, across, true);
    pass(across, made, false);
    return made;
}

/// The mean of what the blurred tone is off.
double errorOf(const std::vector<InkLine>& lines, double tone) {
    Strokes strokes;
    for (const auto& line : lines) {
        std::vector<glm::dvec2> places;
        for (const auto& point : line.points) places.push_back(point.at);
        test::addStroke(strokes, places, lineWidth);
    }
    auto off = plainlyBlurred(test::coverOf(strokes, columns, rows), reading);
    for (auto& value : off.values) value = std::abs(value - tone);
    return test::meanOf(off, 0);
}

using Way = std::array<double, 4>;

std::vector<Way> waysOf(const std::vector<InkLine>& lines) {
    std::vector<Way> ways;
    for (const auto& line : lines) {
        for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
            const auto &a = line.points[i].at, &b = line.points[i + 1].at;
            ways.push_back({a.x, a.y, b.x, b.y});
        }
    }
    std::sort(ways.begin(), ways.end());
    return ways;
}

TEST(ChooseLines, AdjustedMeetsTheTarget) {
    test::Random random(8);
    for (const double tone : {0.1, 0.25, 0.45}) {
        const auto lines = manyLines(random, 900, 1.0);
        const Target target(tone);
        auto style = test::usualInk().silhouettes;
        style.mode = SilhouetteMode::all;
        const double all = errorOf(target.chosen(lines, style).lines, tone);
        style.mode = SilhouetteMode::adjusted;
        const double adjusted = errorOf(target.chosen(lines, style).lines, tone);
        EXPECT_GT(all, 0.25) << tone;
        EXPECT_LT(adjusted, 0.06) << tone;
    }
}

TEST(ChooseLines, WhereLinesAreNotTooDarkAllAreDrawn) {
    test::Random random(9);
    const auto lines = manyLines(random, 30, 1.0);
    EXPECT_EQ(waysOf(Target(0.8).chosen(lines, test::usualInk().silhouettes).lines), waysOf(lines));
}

TEST(ChooseLines, ImportantDrawsThoseAboveAndNoneNothing) {
    test::Random random(10);
    const auto lines = manyLines(random, 200, 1.0);
    const double threshold = 0.5;
    // Pieces as long as a target says, or what is left at a line's end: of the mean step.
    std::vector<InkLine> above;
    for (const auto& line : lines) {
        for (std::size_t begin = 0; begin + 1 < line.points.size();) {
            const std::size_t end = std::min(begin + 3, line.points.size() - 1);
            double steps = 0.0;
            for (std::size_t i = begin; i < end; ++i) steps += line.points[i].step;
            if (steps > threshold * static_cast<double>(end - begin))
                above.push_back({line.kind,
                                 {line.points.begin() + static_cast<std::ptrdiff_t>(begin),
                                  line.points.begin() + static_cast<std::ptrdiff_t>(end) + 1}});
            begin = end;
        }
    }
    const Target target(0.05);
    auto style = test::usualInk().silhouettes;
    style.mode = SilhouetteMode::important;
    style.importance = threshold;
    const auto important = waysOf(target.chosen(lines, style).lines);
    EXPECT_EQ(important, waysOf(above));
    EXPECT_LT(important.size(), waysOf(lines).size());

    style.mode = SilhouetteMode::adjusted;
    const auto adjusted = waysOf(target.chosen(lines, style).lines);
    EXPECT_TRUE(std::includes(adjusted.begin(), adjusted.end(), important.begin(), important.end()));

    style.mode = SilhouetteMode::none;
    const auto none = target.chosen(lines, style);
    EXPECT_TRUE(none.lines.empty());
    EXPECT_EQ(none.density, ToneGrid(target.cells.columns, target.cells.rows));
}

TEST(ChooseLines, TheOrderOfLinesDoesNotMatter) {
    test::Random random(11);
    auto lines = manyLines(random, 300, 1.0);
    const Target target(0.2);
    const auto before = waysOf(target.chosen(lines, test::usualInk().silhouettes).lines);
    for (std::size_t i = lines.size() - 1; i > 0; --i) std::swap(lines[i], lines[random.below(i + 1)]);
    EXPECT_EQ(waysOf(target.chosen(lines, test::usualInk().silhouettes).lines), before);
    EXPECT_LT(before.size(), waysOf(lines).size());
}

TEST(ChooseLines, DensityIsThatOfWhatIsDrawn) {
    test::Random random(12);
    const auto lines = manyLines(random, 300, 1.0);
    const Target target(0.2);
    const auto chosen = target.chosen(lines, test::usualInk().silhouettes);
    const auto again = densityOf(chosen.lines, target.cells, lineWidth);
    double most = 0.0;
    // What is blurred beyond a side comes back in one of them.
    for (std::uint32_t row = 12; row + 12 < again.height; ++row) {
        for (std::uint32_t column = 12; column + 12 < again.width; ++column)
            most = std::max(most,
                            std::abs(double(again.at(column, row)) - double(chosen.density.at(column, row))));
    }
    EXPECT_LT(most, 1e-4);
}

TEST(ChooseLines, ExtremesDoNoHarm) {
    test::Random random(13);
    auto lines = manyLines(random, 20, 1.0);
    lines.push_back({LineKind::crease, {{{3.0, 3.0}}, {{3.0, 3.0}}}});
    lines.push_back({LineKind::crease, {{{-1e9, 3.0}}, {{1e9, 4.0}}}});
    for (const double size : {1.0, 6.0, 256.0}) {
        const ToneCells cells(64, 48, size);
        for (const float tone : {0.0F, 1.0F, std::nanf("")}) {
            const ToneGrid grid(cells.columns, cells.rows, tone);
            for (const double width : {0.1, 64.0})
                EXPECT_LE(
                    chooseLines(lines, test::usualInk().silhouettes, {cells, grid, width, 2.0 * size}, {})
                        .lines.size(),
                    500U);
        }
    }
}

}  // namespace
}  // namespace mote::render
