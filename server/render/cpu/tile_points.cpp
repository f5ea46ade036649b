// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/tile_points.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "server/render/cpu/preview_blocks.h"

namespace mote::render {
namespace {

/// Leaves that are sorted by one task.
constexpr std::size_t chunkLeaves = std::size_t{1} << 14;
constexpr std::size_t blockLeaves = 1024;
constexpr std::size_t chunkBlocks = 16;  // of the preview

/// The leaves of a layer that are drawn, chunk by chunk, with the tiles that they can touch.
class LeafTiles {
  public:
    LeafTiles(const LayerPlan& layer, const PointMap& map, std::span<const LeafCell> cells, float margin)
        : layer_(layer), leaves_(layer.step->leaves()), map_(map), cells_(cells), margin_(margin) {}

    std::size_t chunks() const { return (cells_.size() + chunkLeaves - 1) / chunkLeaves; }

    /// Calls visit(tile, leaf points) for each tile that a leaf of the chunk can touch. Returns the points of
    /// leaves that touch one.
    template <class Visit>
    std::uint64_t forEach(std::size_t chunk, std::uint32_t columns, Visit visit) const {
        if (!drawsAny(chunk)) return 0;
        verify(chunk);
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

  private:
    bool drawsAny(std::size_t chunk) const {
        for (std::size_t i = chunk * chunkLeaves; i < std::min(cells_.size(), (chunk + 1) * chunkLeaves);
             ++i) {
            if (layer_.drawn(i) > 0) return true;
        }
        return false;
    }

    /// Of the chunk's points, that their bytes are right.
    void verify(std::size_t chunk) const {
        const std::size_t first = chunk * chunkLeaves,
                          last = std::min(cells_.size(), first + chunkLeaves) - 1;
        const std::uint64_t begin = leaves_.pointBegin[first];
        layer_.step->positions(begin, leaves_.pointBegin[last] + leaves_.pointCount[last] - begin);
    }

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
    const LeafTiles leafTiles(layer, *map_, cells, reach());
    std::atomic<std::uint64_t> drawn{0};
    leaves_.fill(tiles, leafTiles.chunks(), stop,
                 [&](std::size_t chunk, auto visit) { drawn += leafTiles.forEach(chunk, columns_, visit); });
    pointsDrawn_ = drawn / 2;  // each chunk was visited twice
    sortPreview(layer, tiles, stop);
    return !stop.stop_requested();
}

void TilePoints::sortPreview(const LayerPlan& layer, std::size_t tiles, const std::stop_token& stop) {
    const PreviewBlocks blocks(layer);
    std::atomic<std::uint64_t> drawn{0};
    const std::size_t chunks = (blocks.count() + chunkBlocks - 1) / chunkBlocks;
    preview_.fill(tiles, chunks, stop, [&](std::size_t chunk, auto visit) {
        std::array<ScreenPoint, PreviewBlocks::blockPoints> screen;
        const std::size_t end = std::min(blocks.count(), (chunk + 1) * chunkBlocks);
        for (std::size_t block = chunk * chunkBlocks; block < end; ++block) {
            const std::size_t hits = projectPreview(*map_, blocks.block(block), reach(), screen.data());
            drawn += hits;
            for (std::size_t i = 0; i < hits; ++i) visitTiles(screen[i], visit);
        }
    });
    pointsDrawn_ += drawn / 2;
}

template <class Visit>
void TilePoints::visitTiles(const ScreenPoint& point, Visit visit) const {
    // Not below zero, so that rounding towards it is rounding down.
    const auto first = [this](float pixel) {
        return static_cast<std::uint32_t>(std::max(pixel - reach(), 0.0F)) / Tile::edge;
    };
    const auto last = [this](float pixel, std::uint32_t across) {
        return std::min(static_cast<std::uint32_t>(std::max(pixel + reach(), 0.0F)) / Tile::edge, across - 1);
    };
    const std::uint32_t bottom = last(point.y, tilesAcross(map_->height)), right = last(point.x, columns_);
    for (std::uint32_t row = first(point.y); row <= bottom; ++row) {
        for (std::uint32_t column = first(point.x); column <= right; ++column) {
            visit(std::size_t{row} * columns_ + column, point);
        }
    }
}

void TilePoints::gather(Tile tile, TileCells& cells) const {
    const auto leaves = leaves_.of(index(tile));
    if (discs_) {
        addDiscs(leaves, tile, cells);
    } else {
        gatherPoints(*map_, leaves.data(), leaves.size(), points_, end_, tile, cells);
    }
    for (const auto& point : preview_.of(index(tile))) add(point, tile, cells);
    cells.settle();
}

void TilePoints::addDiscs(std::span<const LeafPoints> leaves, Tile tile, TileCells& cells) const {
    std::array<ScreenPoint, LeafPoints::mostPoints> screen;
    for (const auto& leaf : leaves) {
        const std::size_t hits =
            projectPoints(*map_, leaf.cell, points_ + leaf.begin, leaf.count(), end_, reach(), screen.data());
        for (std::size_t i = 0; i < hits; ++i) add(screen[i], tile, cells);
    }
}

void TilePoints::add(const ScreenPoint& point, Tile tile, TileCells& cells) const {
    constexpr auto edge = static_cast<std::int32_t>(Tile::edge);
    const auto left = static_cast<std::int32_t>(tile.column) * edge;
    const auto top = static_cast<std::int32_t>(tile.row) * edge;
    const std::uint32_t slab = std::min(static_cast<std::uint32_t>(point.slab), cells.slabs() - 1);
    const float place = point.slab - static_cast<float>(slab);
    const auto addTo = [&](std::int32_t column, std::int32_t row, float weight) {
        const std::uint32_t pixel = Tile::pixelIndex(static_cast<std::uint32_t>(column - left),
                                                     static_cast<std::uint32_t>(row - top));
        PointCell& cell = cells.cells()[std::size_t{slab} * Tile::pixels + pixel];
        cell.weight += weight;
        cell.depth += weight * place;
        cells.touched()[slab * Tile::packets + pixel / Tile::packetPixels] = 1;
    };
    if (discs_) return discs_->spread(point.x, point.y, {left, top, left + edge, top + edge}, addTo);
    // Where a point lies on the picture's very edge it belongs to no pixel.
    const auto column = static_cast<std::int32_t>(point.x), row = static_cast<std::int32_t>(point.y);
    if (column < left + edge && row < top + edge) addTo(column, row, 1.0F);
}

}  // namespace mote::render
