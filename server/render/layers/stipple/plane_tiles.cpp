// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/stipple/plane_tiles.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>

#include "protocol/base/mote_check.h"
#include "server/render/plan/in_turns.h"

namespace mote::render {
namespace {

using Range = tbb::blocked_range<std::size_t>;

constexpr double pointsInCell = 8.0;  ///< of the grid, about
constexpr int mostCells = 64;         ///< of the grid, along a side of the tile
/// The margin beyond the picture's edges, in spacings of the full density, so that what lies there keeps the
/// dots at the edge in their places.
constexpr double tileMarginSpacings = 6.0;

Tiling tilingOf(const PixelMap& wanted, double side, double spacing) {
    Tiling tiling;
    tiling.side = side;
    tiling.margin = tileMarginSpacings * spacing;
    tiling.right = wanted.width() + tiling.margin;
    tiling.bottom = wanted.height() + tiling.margin;
    tiling.firstColumn = tiling.firstRow = static_cast<int>(std::floor(-tiling.margin / side));
    tiling.columns = static_cast<int>(std::floor(tiling.right / side)) - tiling.firstColumn + 1;
    tiling.rows = static_cast<int>(std::floor(tiling.bottom / side)) - tiling.firstRow + 1;
    return tiling;
}

}  // namespace

PlaneTiles::PlaneTiles(std::shared_ptr<const storage::StippleHierarchy> hierarchy)
    : hierarchy_(std::move(hierarchy)),
      gridSide_(
          std::clamp(static_cast<int>(std::sqrt(static_cast<double>(size()) / pointsInCell)), 1, mostCells)) {
    const auto& h = *hierarchy_;
    const auto gridCell = [this](float coordinate) {
        return std::clamp(static_cast<int>(coordinate * static_cast<float>(gridSide_)), 0, gridSide_ - 1);
    };
    const auto cellOf = [&](std::size_t point) {
        return static_cast<std::size_t>(gridCell(h.positions[point].y) * gridSide_ +
                                        gridCell(h.positions[point].x));
    };
    cellBegin_.assign(static_cast<std::size_t>(gridSide_ * gridSide_ + 1), 0);
    for (std::size_t i = 0; i < h.size(); ++i) ++cellBegin_[cellOf(i) + 1];
    std::partial_sum(cellBegin_.begin(), cellBegin_.end(), cellBegin_.begin());
    auto next = cellBegin_;
    candidates_.resize(h.size());
    const auto all = static_cast<double>(h.size());
    for (std::size_t i = 0; i < h.size(); ++i) {
        candidates_[next[cellOf(i)]++] = {h.positions[i].x, h.positions[i].y,
                                          static_cast<float>((all - 0.5 - h.removal[i]) / all),
                                          static_cast<std::uint32_t>(i)};
    }
}

std::uint64_t PlaneTiles::bytes() const {
    return hierarchy_->bytes() + candidates_.capacity() * sizeof(Candidate) +
           cellBegin_.capacity() * sizeof(cellBegin_[0]);
}

std::vector<TileDot> PlaneTiles::find(const PixelMap& wanted, const Tiling& tiling,
                                      const TileFrame& frame) const {
    // A strip is a row of cells of a row of tiles: strips in order give the same list on any threads.
    const auto strips = static_cast<std::size_t>(tiling.rows * gridSide_);
    std::vector<std::vector<TileDot>> found(strips);
    const double cellSide = tiling.side / gridSide_;
    const auto drawn = [&](const Candidate& candidate, double x, double y) {
        const double density = candidate.left * frame.density;
        const double square = frame.sampleSide / std::sqrt(std::max(density, 1e-12));
        return density < wanted.mean(x, y, square);
    };
    const auto scanCell = [&](int column, int row, int cell, std::vector<TileDot>& dots) {
        for (auto i = cellBegin_[cell]; i < cellBegin_[cell + 1]; ++i) {
            const auto& candidate = candidates_[i];
            const double x = (column + candidate.x) * tiling.side;
            const double y = (row + candidate.y) * tiling.side;
            if (drawn(candidate, x, y)) {
                dots.push_back({column, row, candidate.point, {}});
            }
        }
    };
    forRangesInTurns(strips, 1, [&](const Range& range) {
        for (auto strip = range.begin(); strip != range.end(); ++strip) {
            const int row = tiling.firstRow + static_cast<int>(strip) / gridSide_;
            const int cellRow = static_cast<int>(strip) % gridSide_;
            const double top = row * tiling.side + cellRow * cellSide;
            if (top > tiling.bottom || top + cellSide < -tiling.margin) continue;
            for (int column = tiling.firstColumn; column < tiling.firstColumn + tiling.columns; ++column) {
                for (int cell = 0; cell < gridSide_; ++cell) {
                    const double left = column * tiling.side + cell * cellSide;
                    if (left > tiling.right || left + cellSide < -tiling.margin) continue;
                    scanCell(column, row, cellRow * gridSide_ + cell, found[strip]);
                }
            }
        }
    });
    std::vector<TileDot> dots;
    for (const auto& part : found) dots.insert(dots.end(), part.begin(), part.end());
    return dots;
}

glm::vec2 PlaneTiles::placed(const TileDot& dot, const TileSelection& selection) const {
    const auto& h = *hierarchy_;
    const auto& tiling = selection.tiling;
    const glm::vec3 first = h.positions[dot.point];
    // The neighbour is its image that lies nearest, which may be in the next tile. A forged one may lie
    // further than there are numbers of tiles.
    constexpr float furthest = 1e6F;
    const auto isDrawn = [&](std::uint32_t neighbour) {
        const glm::vec3 apart = glm::clamp(first - h.positions[neighbour], -furthest, furthest);
        const int column = dot.column + static_cast<int>(std::lround(apart.x));
        const int row = dot.row + static_cast<int>(std::lround(apart.y));
        return tiling.has(column, row) &&
               selection.drawn[tiling.index(column, row) * size() + neighbour] != 0;
    };
    auto move = h.movesBegin[dot.point];
    while (move < h.movesBegin[dot.point + 1] && !isDrawn(h.moveNeighbour[move])) ++move;
    const glm::vec3 place = move == h.movesBegin[dot.point] ? first : h.movePosition[move - 1];
    return {static_cast<float>((dot.column + static_cast<double>(place.x)) * tiling.side),
            static_cast<float>((dot.row + static_cast<double>(place.y)) * tiling.side)};
}

TileSelection PlaneTiles::select(const PixelMap& wanted, const TileFrame& frame) const {
    MOTE_CHECK(frame.density > 0.0);
    const double side = std::sqrt(static_cast<double>(size()) / frame.density);
    TileSelection selection{tilingOf(wanted, side, 1.0 / std::sqrt(frame.density)), {}, {}};
    const auto& tiling = selection.tiling;
    selection.dots = find(wanted, tiling, frame);
    selection.drawn.resize(size() * static_cast<std::size_t>(tiling.columns) *
                           static_cast<std::size_t>(tiling.rows));
    for (const auto& dot : selection.dots) selection.drawn[flagOf(tiling, dot)] = 1;
    return selection;
}

void PlaneTiles::place(TileSelection& selection) const {
    auto& dots = selection.dots;
    forRangesInTurns(dots.size(), 1024, [&](const Range& range) {
        for (auto i = range.begin(); i != range.end(); ++i) dots[i].place = placed(dots[i], selection);
    });
}

std::optional<TileDot> PlaneTiles::wake(TileSelection& selection, const glm::dvec2& place) const {
    const auto& tiling = selection.tiling;
    std::optional<TileDot> nearest;
    double least = std::numeric_limits<double>::max();
    const auto cellAt = glm::floor(place / tiling.side * static_cast<double>(gridSide_));
    // A forged hierarchy's dots may lie anywhere, and so may the middles of what is theirs.
    constexpr double furthest = 1e9;
    if (!(std::abs(cellAt.x) < furthest && std::abs(cellAt.y) < furthest)) return nearest;
    const glm::ivec2 middle(cellAt);
    for (int y = middle.y - 1; y <= middle.y + 1; ++y) {
        for (int x = middle.x - 1; x <= middle.x + 1; ++x) {
            const int column = static_cast<int>(std::floor(static_cast<double>(x) / gridSide_));
            const int row = static_cast<int>(std::floor(static_cast<double>(y) / gridSide_));
            if (!tiling.has(column, row)) continue;
            const auto cell =
                static_cast<std::size_t>((y - row * gridSide_) * gridSide_ + x - column * gridSide_);
            for (auto i = cellBegin_[cell]; i < cellBegin_[cell + 1]; ++i) {
                const auto& candidate = candidates_[i];
                const TileDot dot{column, row, candidate.point, {}};
                const glm::dvec2 apart{(column + candidate.x) * tiling.side - place.x,
                                       (row + candidate.y) * tiling.side - place.y};
                const double distance = glm::dot(apart, apart);
                if (distance >= least || selection.drawn[flagOf(tiling, dot)] != 0) continue;
                least = distance;
                nearest = dot;
            }
        }
    }
    if (nearest) selection.drawn[flagOf(tiling, *nearest)] = 1;
    return nearest;
}

}  // namespace mote::render
