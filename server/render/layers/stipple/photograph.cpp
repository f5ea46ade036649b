// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/stipple/photograph.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "protocol/base/mote_check.h"
#include "protocol/scene/fields/facts.h"
#include "protocol/scene/srgb.h"
#include "protocol/scene/write_fields.h"
#include "server/render/layers/stipple/dot_cells.h"
#include "server/render/layers/stipple/tone.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/long_list.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

/// A cell that holds less is given to its neighbours; one that holds more than `most` gets another dot
/// (Deussen, Spicker and Zheng, "Weighted Linde-Buzo-Gray stippling", 2017).
constexpr double least = 0.65;
constexpr double most = 1.35;
/// `least` in the last step, after which nobody fills what a dot leaves.
constexpr double leastAtLast = 0.5;

/// The weighted middle of the quarters of the square that is the dot's share of the picture: half a step of
/// weighted Voronoi relaxation, without cells (dissertation 2.2.3.3).
glm::vec2 weighted(const PixelMap& wanted, const glm::vec2& place) {
    const double density = wanted.mean(place.x, place.y, 1.0);
    const double side = std::min(1.0 / std::sqrt(std::max(density, 1e-6)), 64.0);
    const double quarter = 0.25 * side;
    glm::dvec2 sum(0.0);
    double weight = 0.0;
    for (const auto& [x, y] : {std::pair{-1.0, -1.0}, {1.0, -1.0}, {-1.0, 1.0}, {1.0, 1.0}}) {
        const double w = wanted.mean(place.x + x * quarter, place.y + y * quarter, 0.5 * side);
        sum += w * glm::dvec2(x, y);
        weight += w;
    }
    return weight > 0.0 ? place + glm::vec2(sum * (quarter / weight)) : place;
}

void weigh(const PixelMap& wanted, std::vector<TileDot>& dots) {
    using Range = tbb::blocked_range<std::size_t>;
    forRangesInTurns(dots.size(), 1024, [&](const Range& range) {
        for (auto i = range.begin(); i != range.end(); ++i) dots[i].place = weighted(wanted, dots[i].place);
    });
}

/// By how much finer than its pixels a picture is stippled: cells are told by pixels, and those of dots that
/// lie closer hold too few (at 1.4 pixels tones are off by .04, at 1.775 by .01).
std::uint32_t finerBy(double spacing, std::uint32_t width, std::uint32_t height) {
    constexpr double leastSpacing = 1.75;  // pixels
    constexpr std::uint32_t most = 4;
    constexpr std::uint64_t mostPixels = std::uint64_t{1} << 26;
    std::uint32_t fine = 1;
    while (fine < most && spacing * fine < leastSpacing &&
           std::uint64_t{width} * height * (fine + 1) * (fine + 1) <= mostPixels)
        ++fine;
    return fine;
}

std::vector<DotCell> cellsOf(const PixelMap& wanted, const std::vector<TileDot>& dots) {
    std::vector<glm::vec2> places(dots.size());
    std::transform(dots.begin(), dots.end(), places.begin(), [](const TileDot& dot) { return dot.place; });
    return dotCells(wanted, places);
}

/// The way from a cell's middle to that of its half along its longer axis, were it an ellipse of even
/// density.
glm::dvec2 halfWay(const DotCell& cell) {
    const double mean = 0.5 * (cell.xx + cell.yy);
    const double apart = std::hypot(0.5 * (cell.xx - cell.yy), cell.xy);
    const double angle = 0.5 * std::atan2(2.0 * cell.xy, cell.xx - cell.yy);
    return 0.85 * std::sqrt(std::max(mean + apart, 0.0)) * glm::dvec2(std::cos(angle), std::sin(angle));
}

/// A step of weighted Voronoi relaxation; cells that hold too much are halved.
void relax(const PlaneTiles& tiles, const PixelMap& wanted, TileSelection& selection, bool last) {
    const auto cells = cellsOf(wanted, selection.dots);
    std::vector<TileDot> next;
    next.reserve(selection.dots.size());
    for (std::size_t i = 0; i < cells.size(); ++i) {
        giveWay();
        const auto& cell = cells[i];
        auto dot = selection.dots[i];
        if (cell.mass < (last ? leastAtLast : least)) {
            tiles.letSleep(selection, dot);
            continue;
        }
        dot.place = cell.centroid;
        next.push_back(dot);
        if (cell.mass <= most || last) continue;
        auto woken = tiles.wake(selection, cell.centroid);
        if (!woken) continue;
        const auto half = halfWay(cell);
        next.back().place = cell.centroid - half;
        woken->place = cell.centroid + half;
        next.push_back(*woken);
    }
    selection.dots = std::move(next);
}

}  // namespace

Dots photographDots(const PlaneTiles& tiles, const PixelMap& luminance, std::uint32_t width,
                    std::uint32_t height, const StippleStyle& style, const PhotographEffort& effort) {
    const double size = lengthOf(style, style.kDotPixelsFieldNumber);
    const glm::vec3 color(readColor(style.color()));
    PhotographTone tone{lengthOf(style, style.kSpacingPixelsFieldNumber), size, style.gamma(),
                        denseInDark(style)};
    const auto fine = finerBy(tone.spacing, width, height);
    tone.spacing *= fine;
    tone.dot *= fine;
    const auto wanted = wantedDensity(luminance, width * fine, height * fine, tone);
    const float pixel = 1.0F / static_cast<float>(fine);
    Dots dots;
    for (const auto& dot : stipplePhotograph(tiles, wanted, {tone.fullDensity()}, effort)) {
        giveWay();
        dots.push_back({dot.place.x * pixel, dot.place.y * pixel, std::numeric_limits<double>::infinity(),
                        static_cast<float>(0.5 * size), static_cast<float>(style.opacity()), color});
    }
    return dots;
}

PixelMap luminanceOf(const Picture& picture) {
    MOTE_CHECK(picture.format == PixelFormat::srgb8);
    std::array<float, 256> linear{};
    for (std::size_t i = 0; i < linear.size(); ++i) {
        linear[i] = static_cast<float>(srgbToLinear(static_cast<double>(i) / 255.0));
    }
    constexpr std::size_t grain = std::size_t{1} << 16;
    auto values = listInTurns<float>(picture.pixels.size() / 4);
    forRangesInTurns(values.size(), grain, [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            const std::uint8_t* pixel = &picture.pixels[4 * i];
            values[i] = 0.2126F * linear[pixel[0]] + 0.7152F * linear[pixel[1]] + 0.0722F * linear[pixel[2]];
        }
    });
    return {picture.width, picture.height, std::move(values)};
}

std::vector<TileDot> stipplePhotograph(const PlaneTiles& tiles, const PixelMap& wanted,
                                       const TileFrame& frame, const PhotographEffort& effort) {
    auto selection = tiles.select(wanted, frame);
    tiles.place(selection);
    if (effort.weighting) weigh(wanted, selection.dots);
    for (int i = 0; i < effort.relaxations; ++i) {
        relax(tiles, wanted, selection, i + 1 == effort.relaxations);
    }
    std::erase_if(selection.dots, [&](const TileDot& dot) {
        const auto& [x, y] = std::pair{dot.place.x, dot.place.y};
        return x < 0.0F || y < 0.0F || x >= static_cast<float>(wanted.width()) ||
               y >= static_cast<float>(wanted.height());
    });
    return std::move(selection.dots);
}

}  // namespace mote::render
