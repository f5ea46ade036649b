// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/tile_points.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <numeric>
#include <utility>

#include "protocol/base/mote_check.h"
#include "server/render/cpu/point_footprint.h"
#include "server/render/plan/long_list.h"

namespace mote::render {
namespace {

/// Leaves that are sorted by one task.
constexpr std::size_t chunkLeaves = std::size_t{1} << 14;
constexpr std::size_t chunkBlocks = 16;  // of the preview

/// The leaves of a layer of which points are drawn, chunk by chunk, with the tiles that they can touch.
class LeafTiles {
  public:
    /// `found`, `verified`: room for the leaves and for the points of each chunk.
    LeafTiles(const PointsPlan& layer, std::span<const LeafCell> cells,
              std::vector<std::vector<DrawnLeaf>>& found, std::vector<PointRun>& verified)
        : layer_(layer), leaves_(layer.step->leaves()), cells_(cells), found_(found), verified_(verified) {
        found_.resize(chunks());
        verified_.assign(chunks(), {});
    }

    std::size_t chunks() const { return (cells_.size() + chunkLeaves - 1) / chunkLeaves; }

    /// Returns the points of leaves that touch a tile.
    std::uint64_t prepare(std::size_t chunk, const PointMap& map, float margin) {
        const std::size_t begin = chunk * chunkLeaves, end = std::min(cells_.size(), begin + chunkLeaves);
        std::uint64_t drawn = 0;
        found_[chunk].clear();
        std::array<std::uint32_t, blockLeaves> numbers;
        std::size_t size = 0;
        const auto add = [&] {
            drawn += addBlock(chunk, {numbers.data(), size}, map, margin);
            size = 0;
        };
        for (std::size_t i = begin; i < end; ++i) {
            if (layer_.drawn(i) == 0) continue;
            numbers[size++] = static_cast<std::uint32_t>(i);
            if (size == blockLeaves) add();
        }
        if (size > 0) add();
        if (!found_[chunk].empty()) verified_[chunk] = verify(begin, end);
        return drawn;
    }

    /// Calls visit(tile, leaf points) for each tile that a leaf of the chunk can touch.
    template <class Visit>
    void forEach(std::size_t chunk, std::uint32_t columns, Visit visit) const {
        for (const auto& [leaf, box] : found_[chunk]) {
            const std::uint32_t count = layer_.drawn(leaf);
            for (std::uint32_t row = box.top; row < box.bottom; ++row) {
                for (std::uint32_t column = box.left; column < box.right; ++column) {
                    visitRuns(std::size_t{row} * columns + column, leaf, count, visit);
                }
            }
        }
    }

  private:
    static constexpr std::size_t blockLeaves = 256;

    /// Keeps those that touch a tile. Returns how many points of them are drawn.
    std::uint64_t addBlock(std::size_t chunk, std::span<const std::uint32_t> numbers, const PointMap& map,
                           float margin) {
        std::array<LeafCell, blockLeaves> cells;
        std::array<TileBox, blockLeaves> boxes{};
        std::transform(numbers.begin(), numbers.end(), cells.begin(),
                       [this](std::uint32_t leaf) { return cells_[leaf]; });
        leafTiles(map, cells.data(), numbers.size(), margin, boxes.data());
        std::uint64_t drawn = 0;
        for (std::size_t i = 0; i < numbers.size(); ++i) {
            if (boxes[i].left == boxes[i].right) continue;
            drawn += layer_.drawn(numbers[i]);
            found_[chunk].push_back({numbers[i], boxes[i]});
        }
        return drawn;
    }

    /// Checks that the bytes of the leaves' points are right.
    PointRun verify(std::size_t firstLeaf, std::size_t endLeaf) const {
        const std::uint64_t begin = leaves_.pointBegin[firstLeaf];
        const std::uint64_t end = leaves_.pointBegin[endLeaf - 1] + leaves_.pointCount[endLeaf - 1];
        layer_.step->positions(begin, end - begin);
        return {begin, end - begin};
    }

    template <class Visit>
    void visitRuns(std::size_t tile, std::size_t leaf, std::uint32_t count, Visit& visit) const {
        const auto& weights = layer_.selection->weights;
        const std::uint16_t weight = weights.empty() ? LeafPoints::one : weights[leaf];
        std::uint64_t begin = leaves_.pointBegin[leaf];
        for (std::uint64_t left = count; left > 0;) {
            const std::uint64_t run = std::min(left, LeafPoints::mostPoints);
            visit(tile, LeafPoints::of(cells_[leaf], run, begin, layer_.selection->levelOf(leaf), weight));
            begin += run;
            left -= run;
        }
    }

    const PointsPlan& layer_;
    const storage::Leaves leaves_;
    const std::span<const LeafCell> cells_;
    std::vector<std::vector<DrawnLeaf>>& found_;  // by chunk
    std::vector<PointRun>& verified_;
};

/// The groups of a layer that touch tiles, chunk by chunk.
class GroupTiles {
  public:
    GroupTiles(const PointGroups& groups, std::vector<std::vector<DrawnLeaf>>& found)
        : groups_(groups.groups), found_(found) {
        found_.resize(chunks());
    }

    std::size_t chunks() const { return (groups_.size() + chunkGroups - 1) / chunkGroups; }

    /// Returns the points of groups that touch a tile.
    std::uint64_t prepare(std::size_t chunk, const PointMap& map, float margin) {
        const std::size_t begin = chunk * chunkGroups, end = std::min(groups_.size(), begin + chunkGroups);
        std::array<LeafCell, chunkGroups> cells;
        std::array<TileBox, chunkGroups> boxes;
        std::transform(groups_.begin() + static_cast<std::ptrdiff_t>(begin),
                       groups_.begin() + static_cast<std::ptrdiff_t>(end), cells.begin(),
                       [](const LeafPoints& group) { return group.cell; });
        leafTiles(map, cells.data(), end - begin, margin, boxes.data());
        found_[chunk].clear();
        std::uint64_t drawn = 0;
        for (std::size_t i = begin; i < end; ++i) {
            const TileBox& box = boxes[i - begin];
            if (box.left == box.right) continue;
            drawn += groups_[i].count();
            found_[chunk].push_back({static_cast<std::uint32_t>(i), box});
        }
        return drawn;
    }

    template <class Visit>
    void forEach(std::size_t chunk, std::uint32_t columns, Visit visit) const {
        for (const auto& [group, box] : found_[chunk]) {
            for (std::uint32_t row = box.top; row < box.bottom; ++row) {
                for (std::uint32_t column = box.left; column < box.right; ++column)
                    visit(std::size_t{row} * columns + column, groups_[group]);
            }
        }
    }

  private:
    static constexpr std::size_t chunkGroups = 1024;

    const std::vector<LeafPoints>& groups_;
    std::vector<std::vector<DrawnLeaf>>& found_;  // by chunk
};

}  // namespace

bool TilePoints::sort(const FramePlan& plan, const PointsPlan& layer, std::span<const LeafCell> cells,
                      std::shared_ptr<const PointGroups> groups, const PixelColors* colors,
                      const std::stop_token& stop) {
    MOTE_CHECK(layer.step->pointCount() <= std::uint64_t{1} << LeafPoints::levelShift);
    colors_ = colors;
    shaded_ = shadesCells(plan, layer);
    MOTE_CHECK(!shaded_ || layer.selection->points == 0 || !layer.selection->levels.empty());
    groups_ = std::move(groups);
    columns_ = tilesAcross(plan.width);
    tiles_ = std::size_t{columns_} * tilesAcross(plan.height);
    map_ = PointMap::make(plan, layer);
    discs_.reset();
    if (layer.look.size > 1.0) discs_.emplace(layer.look.size, layer.look.discOpacity());
    points_ = layer.step->positions(0, 0).data();
    end_ = points_ + layer.step->pointCount();
    pointsDrawn_ = 0;
    alone_ = standAlone(plan, layer);
    ink_ = pointFootprint(layer.look);
    look_ = layer.look;
    perspective_ = plan.camera.perspective();
    sections_ = plan.sections;
    thinned_ = layer.look.thinned;
    color_ = glm::vec3(layer.look.color);
    // Not by what is found: of several processes each has its own part of the points.
    slabs_ = layer.pointsDrawn > 0 && !alone_ ? map_->slabs() : 0;
    const bool stream = !groups_ && PointStream::serves(plan, layer, *map_);
    const auto blocks = stream ? PreviewBlocks(stream_.of(layer, cells)) : PreviewBlocks(layer);
    if (groups_) {
        sortGroups(stop);
    } else {
        sortLeaves(layer, stream ? std::span<const LeafCell>() : cells, stop);
    }
    sortDiscs(discs_ ? blocks : PreviewBlocks(), stop);
    sortPixels(discs_ ? PreviewBlocks() : blocks, stop);
    return !stop.stop_requested();
}

void TilePoints::sortLeaves(const PointsPlan& layer, std::span<const LeafCell> cells,
                            const std::stop_token& stop) {
    verified_.clear();
    // Without leaves to draw, the octree need not even be there.
    if (cells.empty()) return leaves_.clear(tiles_);
    fillFrom(LeafTiles(layer, cells, drawnLeaves_, verified_), stop);
}

void TilePoints::sortGroups(const std::stop_token& stop) {
    verified_.clear();
    fillFrom(GroupTiles(*groups_, drawnLeaves_), stop);
}

/// Of leaves, or of groups.
template <class Chunks>
void TilePoints::fillFrom(Chunks chunks, const std::stop_token& stop) {
    std::atomic<std::uint64_t> drawn{0};
    leaves_.fill(
        tiles_, chunks.chunks(), stop,
        [&](std::size_t chunk) { drawn += chunks.prepare(chunk, *map_, reach()); },
        [&](std::size_t chunk, auto visit) { chunks.forEach(chunk, columns_, visit); });
    pointsDrawn_ += drawn;
}

void TilePoints::sortDiscs(const PreviewBlocks& blocks, const std::stop_token& stop) {
    std::atomic<std::uint64_t> drawn{0};
    const auto forEach = [&](std::size_t block, auto visit) {
        std::array<ScreenPoint, PreviewBlocks::blockPoints> screen;
        const std::size_t hits = projectPreview(*map_, blocks.block(block), reach(), screen.data());
        drawn += hits;
        for (std::size_t i = 0; i < hits; ++i) visitTiles(screen[i], visit);
    };
    discPoints_.fill(
        tiles_, blocks.count(), stop, [](std::size_t) {}, forEach);
    pointsDrawn_ += drawn / 2;  // each block was visited twice
}

void TilePoints::sortPixels(const PreviewBlocks& blocks, const std::stop_token& stop) {
    constexpr std::size_t chunkPoints = chunkBlocks * PreviewBlocks::blockPoints;
    const std::size_t chunks = (blocks.count() + chunkBlocks - 1) / chunkBlocks;
    std::vector<std::size_t> hits(chunks, 0);
    resizeInTurns(pointTiles_, blocks.points());
    resizeInTurns(unsorted_, blocks.points());
    const auto prepare = [&](std::size_t chunk) {
        const std::size_t end = std::min(blocks.count(), (chunk + 1) * chunkBlocks);
        for (std::size_t block = chunk * chunkBlocks; block < end; ++block) {
            const std::size_t to = chunk * chunkPoints + hits[chunk];
            hits[chunk] += packPreview(*map_, blocks.block(block), columns_, pointTiles_.data() + to,
                                       unsorted_.data() + to);
        }
    };
    const auto forEach = [&](std::size_t chunk, auto visit) {
        const std::size_t begin = chunk * chunkPoints;
        for (std::size_t i = begin; i < begin + hits[chunk]; ++i) visit(pointTiles_[i], unsorted_[i]);
    };
    pixelPoints_.fill(tiles_, chunks, stop, prepare, forEach);
    pointsDrawn_ = std::accumulate(hits.begin(), hits.end(), pointsDrawn_);
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
    if (alone_) return;
    const auto leaves = leaves_.of(index(tile));
    const auto discs = discPoints_.of(index(tile));
    if (discs_ && groups_) {
        gatherGroupedDiscs(*map_, leaves.data(), leaves.size(), groups_->points.data(),
                           groups_->levels.data(), *discs_, tile, cells);
    } else if (groups_) {
        gatherGrouped(*map_, leaves.data(), leaves.size(), groups_->points.data(), groups_->levels.data(),
                      tile, cells);
    } else if (discs_) {
        gatherDiscs(*map_, leaves.data(), leaves.size(), points_, end_, *discs_, tile, cells);
        gatherScreenDiscs(discs.data(), discs.size(), *discs_, tile, cells);
    } else {
        gatherPoints(*map_, leaves.data(), leaves.size(), points_, end_, tile, cells);
    }
    constexpr float step = 1.0F / (1 << placeBits);
    for (const TilePoint point : pixelPoints_.of(index(tile))) {
        const std::uint32_t cell = point >> (placeBits + levelBits);
        PointCell& sums = cells.cells()[cell];
        sums.weight += 1.0F;
        sums.depth += (static_cast<float>(point >> levelBits & ((1U << placeBits) - 1)) + 0.5F) * step;
        cells.touched()[cell / Tile::packetPixels] = 1;
        if (!shaded_) continue;
        PixelShade& shade = cells.shades()[cell % Tile::pixels];
        shade.weight += 1.0F;
        shade.level += static_cast<float>(point & ((1U << levelBits) - 1));
    }
    cells.settle();
}

void TilePoints::appendAlone(Tile tile, std::vector<LonePoint>& out) const {
    if (!alone_) return;
    const bool lit = look_.light > 0.0;
    const float left = static_cast<float>(tile.column * Tile::edge) - reach();
    const float top = static_cast<float>(tile.row * Tile::edge) - reach();
    const float edge = static_cast<float>(Tile::edge) + 2.0F * reach();
    const auto first = static_cast<float>(firstSlab());
    std::array<ScreenPoint, LeafPoints::mostPoints> screen;
    for (const auto& leaf : leaves_.of(index(tile))) {
        const std::size_t hits = projectPoints(*map_, leaf.cell, points_ + leaf.begin(), leaf.count(), end_,
                                               reach(), screen.data());
        for (const auto& point : std::span(screen).first(hits)) {
            if (point.x < left || point.x > left + edge || point.y < top || point.y > top + edge) continue;
            const float place = first + point.slab;
            const double tau =
                lit ? leaf.weight() * look_.tauAt(depthAt(sections_, place), perspective_) * thinned_ : -1.0;
            out.push_back(
                {{point.x, point.y, ink_, place, color_}, thinned_, static_cast<float>(tau), colors_});
        }
    }
}

void TilePoints::verify(const PointsPlan& layer) const {
    for (const PointRun& run : verified_) layer.step->positions(run.begin, run.count);
}

std::uint64_t TilePoints::bytes() const {
    std::size_t drawnLeaves = 0;
    for (const auto& chunk : drawnLeaves_) drawnLeaves += chunk.capacity();
    return leaves_.bytes() + discPoints_.bytes() + pixelPoints_.bytes() + drawnLeaves * sizeof(DrawnLeaf) +
           pointTiles_.capacity() * sizeof(std::uint32_t) + unsorted_.capacity() * sizeof(TilePoint);
}

bool FramePoints::sort(const FramePlan& plan, ResidentLeaves& leaves, ResidentGroups* groups,
                       const FrameColors& colors, const std::stop_token& stop) {
    layers_.resize(plan.points.size());
    for (std::size_t i = 0; i < layers_.size(); ++i) {
        const PointsPlan& layer = plan.points[i];
        const auto cells = leaves.of(layer.step).upTo(*layer.step, layer.selection->drawn.size());
        std::shared_ptr<const PointGroups> grouped;
        if (groups != nullptr && !standAlone(plan, layer) &&
            PointGroups::serve(plan, layer, PointMap::make(plan, layer))) {
            grouped = groups->of(layer, cells, stop);
            if (grouped == nullptr) return false;
        }
        if (!layers_[i].sort(plan, layer, cells, std::move(grouped), colors[i].get(), stop)) return false;
    }
    return true;
}

bool FramePoints::any(Tile tile) const {
    return std::any_of(layers_.begin(), layers_.end(), [&](const auto& layer) { return layer.any(tile); });
}

std::span<TileCells> FramePoints::gather(Tile tile) {
    auto& cells = cells_.local();
    cells.resize(layers_.size(), TileCells(0));
    for (std::size_t i = 0; i < layers_.size(); ++i) {
        const std::uint32_t slabs = layers_[i].slabs(), first = layers_[i].firstSlab();
        const bool shaded = layers_[i].shaded();
        if (cells[i].slabs() == slabs && cells[i].firstSlab() == first && cells[i].shaded() == shaded) {
            cells[i].clear();
        } else {
            cells[i] = TileCells(slabs, first, shaded);
        }
        layers_[i].gather(tile, cells[i]);
    }
    return cells;
}

void FramePoints::appendAlone(Tile tile, std::vector<LonePoint>& out) const {
    for (const auto& layer : layers_) layer.appendAlone(tile, out);
}

std::uint64_t FramePoints::pointsDrawn(bool alone) const {
    std::uint64_t points = 0;
    for (const auto& layer : layers_) points += layer.alone() && !alone ? 0 : layer.pointsDrawn();
    return points;
}

void FramePoints::verify(const FramePlan& plan) const {
    for (std::size_t i = 0; i < layers_.size(); ++i) layers_[i].verify(plan.points[i]);
}

std::uint64_t FramePoints::bytes() const {
    std::uint64_t bytes = 0;
    for (const auto& layer : layers_) bytes += layer.bytes();
    return bytes;
}

}  // namespace mote::render
