// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/tile_points.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>

namespace mote::render {
namespace {

/// Leaves that are sorted by one task.
constexpr std::size_t chunkLeaves = std::size_t{1} << 14;
constexpr std::size_t blockLeaves = 1024;

/// The leaves of a layer that are drawn, chunk by chunk, twice alike: to count them by tile, and to place
/// them.
class Sorting {
  public:
    Sorting(const LayerPlan& layer, const PointMap& map, std::span<const LeafCell> cells, float margin)
        : layer_(layer), leaves_(layer.step->leaves()), map_(map), cells_(cells), margin_(margin) {}

    std::size_t chunks() const { return (cells_.size() + chunkLeaves - 1) / chunkLeaves; }

    /// Calls visit(tile, leaf points) for each tile that a leaf of the chunk can touch. Returns the points of
    /// leaves that touch one.
    template <class Visit>
    std::uint64_t forEach(std::size_t chunk, std::uint32_t columns, Visit visit) const {
        std::uint64_t drawn = 0;
        const std::size_t end = std::min(cells_.size(), (chunk + 1) * chunkLeaves);
        std::array<TileBox, blockLeaves> boxes;
        for (std::size_t begin = chunk * chunkLeaves; begin < end; begin += blockLeaves) {
            const std::size_t size = std::min(blockLeaves, end - begin);
            leafTiles(map_, cells_.data() + begin, size, margin_, boxes.data());
            for (std::size_t i = 0; i < size; ++i) {
                const std::uint32_t count = layer_.drawn(begin + i);
                const TileBox& box = boxes[i];
                if (count == 0 || box.left == box.right) continue;
                drawn += count;
                for (std::uint32_t row = box.top; row < box.bottom; ++row) {
                    for (std::uint32_t column = box.left; column < box.right; ++column) {
                        visitRuns(row * columns + column, begin + i, count, visit);
                    }
                }
            }
        }
        return drawn;
    }

    /// Of the chunk's points, that their bytes are right.
    void verify(std::size_t chunk) const {
        const std::size_t first = chunk * chunkLeaves,
                          last = std::min(cells_.size(), first + chunkLeaves) - 1;
        const std::uint64_t begin = leaves_.pointBegin[first];
        layer_.step->positions(begin, leaves_.pointBegin[last] + leaves_.pointCount[last] - begin);
    }

  private:
    template <class Visit>
    void visitRuns(std::size_t tile, std::size_t leaf, std::uint32_t count, Visit& visit) const {
        std::uint64_t begin = leaves_.pointBegin[leaf];
        for (std::uint64_t left = count; left > 0;) {
            const std::uint64_t run = std::min(left, LeafPoints::mostPoints);
            visit(tile, LeafPoints{cells_[leaf] | run << LeafPoints::countShift, begin});
            begin += run;
            left -= run;
        }
    }

    const LayerPlan& layer_;
    const storage::Leaves leaves_;
    const PointMap& map_;
    const std::span<const LeafCell> cells_;
    const float margin_;
};

}  // namespace

bool TilePoints::sort(const FramePlan& plan, const LayerPlan& layer, std::span<const LeafCell> cells,
                      const std::stop_token& stop) {
    columns_ = tilesAcross(plan.width);
    map_ = PointMap::make(plan, layer);
    discs_.reset();
    if (layer.style.pointSize > 1.0) discs_.emplace(layer.style.pointSize, layer.style.pointOpacity);
    points_ = layer.step->positions(0, 0).data();
    end_ = points_ + layer.step->pointCount();

    const std::size_t tiles = std::size_t{columns_} * tilesAcross(plan.height);
    const Sorting sorting(layer, *map_, cells, discs_ ? discs_->reach() : 0.0F);
    const std::size_t chunks = sorting.chunks();
    // Where each chunk's leaves of each tile go: first how many there are, then where they begin.
    std::vector<std::uint32_t> places(chunks * tiles, 0);
    std::atomic<std::uint64_t> drawn{0};
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
        if (stop.stop_requested()) return;
        std::uint32_t* const counts = places.data() + chunk * tiles;
        const std::uint64_t points =
            sorting.forEach(chunk, columns_, [&](std::size_t tile, const LeafPoints&) { ++counts[tile]; });
        if (points > 0) sorting.verify(chunk);
        drawn += points;
    });
    pointsDrawn_ = drawn;
    begin_.assign(tiles + 1, 0);
    for (std::size_t tile = 0; tile < tiles; ++tile) {
        std::size_t count = 0;
        for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
            const auto there = places[chunk * tiles + tile];
            places[chunk * tiles + tile] = static_cast<std::uint32_t>(count);
            count += there;
        }
        begin_[tile + 1] = begin_[tile] + count;
    }
    leaves_.resize(begin_.back());
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
        if (stop.stop_requested()) return;
        std::uint32_t* const next = places.data() + chunk * tiles;
        sorting.forEach(chunk, columns_, [&](std::size_t tile, const LeafPoints& leaf) {
            leaves_[begin_[tile] + next[tile]++] = leaf;
        });
    });
    return !stop.stop_requested();
}

bool TilePoints::any(Tile tile) const {
    return begin_[index(tile)] < begin_[index(tile) + 1];
}

void TilePoints::gather(Tile tile, TileCells& cells) const {
    const std::span<const LeafPoints> leaves(leaves_.data() + begin_[index(tile)],
                                             begin_[index(tile) + 1] - begin_[index(tile)]);
    if (discs_) return gatherDiscs(tile, leaves, cells);
    gatherPoints(*map_, leaves.data(), leaves.size(), points_, end_, tile, cells);
}

void TilePoints::gatherDiscs(Tile tile, std::span<const LeafPoints> leaves, TileCells& cells) const {
    std::array<ScreenPoint, LeafPoints::mostPoints + 16> screen;
    const auto left = static_cast<std::int32_t>(tile.column * Tile::edge);
    const auto top = static_cast<std::int32_t>(tile.row * Tile::edge);
    constexpr auto edge = static_cast<std::int32_t>(Tile::edge);
    const PixelBox box{left, top, left + edge, top + edge};
    for (const auto& leaf : leaves) {
        const std::size_t hits = projectPoints(*map_, leaf.cell, points_ + leaf.begin, leaf.count(), end_,
                                               discs_->reach(), screen.data());
        for (std::size_t i = 0; i < hits; ++i) {
            const ScreenPoint& at = screen[i];
            const std::uint32_t slab = std::min(static_cast<std::uint32_t>(at.slab), cells.slabs() - 1);
            const float place = at.slab - static_cast<float>(slab);
            discs_->spread(at.x, at.y, box, [&](std::int32_t column, std::int32_t row, float weight) {
                const auto x = static_cast<std::uint32_t>(column - left);
                const auto y = static_cast<std::uint32_t>(row - top);
                const std::uint32_t pixel = Tile::pixelIndex(x, y);
                PointCell& cell = cells.cells()[std::size_t{slab} * Tile::pixels + pixel];
                cell.weight += weight;
                cell.depth += weight * place;
                cells.occupied()[slab] |= std::uint64_t{1} << (pixel / Tile::packetPixels);
            });
        }
    }
}

}  // namespace mote::render
