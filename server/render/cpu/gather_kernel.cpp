// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/points_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/render/cpu/gather_kernel.cpp"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "server/render/cpu/point_places-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace {

template <bool perspective>
void leafTilesOf(const PointMap& map, const LeafCell* cells, std::size_t count, float margin,
                 TileBox* boxes) {
    const auto tiles = [](float pixel, std::uint32_t across) {
        const float last = static_cast<float>(across) - 1.0F;
        return static_cast<std::uint16_t>(std::clamp(pixel / static_cast<float>(Tile::edge), 0.0F, last));
    };
    const std::uint32_t columns = tilesAcross(map.width), rows = tilesAcross(map.height);
    LeafPlaces places;
    for (std::size_t begin = 0; begin < count; begin += LeafPlaces::block) {
        const std::size_t size = std::min(LeafPlaces::block, count - begin);
        placeLeaves<perspective>(map, cells + begin, size, places);
        for (std::size_t i = 0; i < size; ++i) {
            boxes[begin + i] = {};
            if (places.outside(map, i, margin)) continue;
            boxes[begin + i] = {tiles(places.left[i] - margin, columns), tiles(places.top[i] - margin, rows),
                                static_cast<std::uint16_t>(tiles(places.right[i] + margin, columns) + 1),
                                static_cast<std::uint16_t>(tiles(places.bottom[i] + margin, rows) + 1)};
        }
    }
}

void leafTiles(const PointMap& map, const LeafCell* cells, std::size_t count, float margin, TileBox* boxes) {
    if (map.perspective) {
        leafTilesOf<true>(map, cells, count, margin, boxes);
    } else {
        leafTilesOf<false>(map, cells, count, margin, boxes);
    }
}

/// Tile::pixelIndex of places within a tile.
HWY_INLINE Int pixelIndex(Int x, Int y) {
    const Int packetX = hn::ShiftRight<2>(x), packetY = hn::ShiftRight<2>(y);
    const Int three = hn::Set(ints, 3);
    const Int packet = hn::Add(hn::ShiftLeft<3>(packetY), packetX);
    const Int inside = hn::Add(hn::ShiftLeft<2>(hn::And(y, three)), hn::And(x, three));
    return hn::Add(hn::ShiftLeft<4>(packet), inside);
}

struct CellSums {
    PointCell* cells;
    std::uint64_t* occupied;

    HWY_INLINE void add(std::uint32_t cell, float place) const {
        cells[cell].weight += 1.0F;
        cells[cell].depth += place;
        occupied[cell / Tile::pixels] |= std::uint64_t{1} << (cell % Tile::pixels / Tile::packetPixels);
    }
};

template <bool perspective>
void gatherLeaves(const PointMap& map, const LeafPoints* leaves, std::size_t leafCount,
                  const PackedPosition* points, const PackedPosition* end, Tile tile, TileCells& cells) {
    static_assert(Tile::edge == 32 && Tile::packetEdge == 4);
    const std::size_t lanes = hn::Lanes(floats);
    const Float tileX = hn::Set(floats, static_cast<float>(tile.column * Tile::edge)),
                tileY = hn::Set(floats, static_cast<float>(tile.row * Tile::edge)),
                edge = hn::Set(floats, static_cast<float>(Tile::edge)), zero = hn::Zero(floats),
                farthest = hn::Set(floats, static_cast<float>(map.slabs));
    const Int lastSlab = hn::Set(ints, static_cast<std::int32_t>(map.slabs) - 1);
    const CellSums sums{cells.cells(), cells.occupied()};
    HWY_ALIGN std::array<std::int32_t, mostLanes> numbers;
    HWY_ALIGN std::array<float, mostLanes> places;
    constexpr std::size_t ahead = 6;  // leaves: their points lie all over the file
    LeafPlaces block;
    HWY_ALIGN std::array<LeafCell, LeafPlaces::block> blockCells;
    for (std::size_t i = 0; i < leafCount; ++i) {
        if (i + ahead < leafCount) __builtin_prefetch(points + leaves[i + ahead].begin);
        const std::size_t inBlock = i % LeafPlaces::block;
        if (inBlock == 0) {
            const std::size_t size = std::min(LeafPlaces::block, leafCount - i);
            for (std::size_t k = 0; k < size; ++k) blockCells[k] = leaves[i + k].cell;
            placeLeaves<perspective>(map, blockCells.data(), size, block);
        }
        const LeafPoints& leaf = leaves[i];
        const LeafMap<perspective> toScreen(map, leaf.cell, block, inBlock);
        const LinearRow toSlab = linearRow(map, leaf.cell, block, inBlock, PointMap::rowSlab);
        const std::size_t count = leaf.count();
        for (std::size_t k = 0; k < count; k += lanes) {
            const Places at = loadPlaces(points + leaf.begin + k, end);
            const Projected pixel = toScreen(at);
            const Float x = hn::Sub(pixel.x, tileX), y = hn::Sub(pixel.y, tileY);
            const Mask inX = hn::And(hn::Ge(x, zero), hn::Lt(x, edge));
            const Mask inY = hn::And(hn::Ge(y, zero), hn::Lt(y, edge));
            const Mask seen = hn::And(hn::And(inX, inY), hn::And(pixel.seen, hn::FirstN(floats, count - k)));
            const Float slab = hn::Min(hn::Max(toSlab(at), zero), farthest);
            const Int slabIndex = hn::Min(hn::ConvertTo(ints, slab), lastSlab);
            const Int cell = hn::Add(hn::ShiftLeft<10>(slabIndex),
                                     pixelIndex(hn::ConvertTo(ints, x), hn::ConvertTo(ints, y)));
            const std::size_t hits =
                hn::CompressStore(cell, hn::RebindMask(ints, seen), ints, numbers.data());
            hn::CompressStore(hn::Sub(slab, hn::ConvertTo(floats, slabIndex)), seen, floats, places.data());
            for (std::size_t hit = 0; hit < hits; ++hit) {
                sums.add(static_cast<std::uint32_t>(numbers[hit]), places[hit]);
            }
        }
    }
}

void gatherPoints(const PointMap& map, const LeafPoints* leaves, std::size_t count,
                  const PackedPosition* points, const PackedPosition* end, Tile tile, TileCells& cells) {
    if (map.perspective) {
        gatherLeaves<true>(map, leaves, count, points, end, tile, cells);
    } else {
        gatherLeaves<false>(map, leaves, count, points, end, tile, cells);
    }
}

/// Keeps the points of a vector that lie within a margin of the picture.
struct NearView {
    Float low, right, bottom, farthest;

    HWY_INLINE NearView(const PointMap& map, float margin)
        : low(hn::Set(floats, -margin)),
          right(hn::Set(floats, static_cast<float>(map.width) + margin)),
          bottom(hn::Set(floats, static_cast<float>(map.height) + margin)),
          farthest(hn::Set(floats, static_cast<float>(map.slabs))) {}

    HWY_INLINE std::size_t store(const Projected& at, Float slab, Mask drawn, ScreenPoint* out) const {
        const Mask inX = hn::And(hn::Ge(at.x, low), hn::Le(at.x, right));
        const Mask inY = hn::And(hn::Ge(at.y, low), hn::Le(at.y, bottom));
        const Mask seen = hn::And(hn::And(inX, inY), hn::And(at.seen, drawn));
        HWY_ALIGN std::array<float, mostLanes> xs, ys, slabs;
        const std::size_t hits = hn::CompressStore(at.x, seen, floats, xs.data());
        hn::CompressStore(at.y, seen, floats, ys.data());
        hn::CompressStore(hn::Min(hn::Max(slab, hn::Zero(floats)), farthest), seen, floats, slabs.data());
        for (std::size_t hit = 0; hit < hits; ++hit) out[hit] = {xs[hit], ys[hit], slabs[hit]};
        return hits;
    }
};

template <bool perspective>
std::size_t projectPointsOf(const PointMap& map, LeafCell cell, const PackedPosition* points,
                            std::size_t count, const PackedPosition* end, float margin, ScreenPoint* out) {
    LeafPlaces leaf;
    placeLeaves<perspective>(map, &cell, 1, leaf);
    const LeafMap<perspective> toScreen(map, cell, leaf, 0);
    const LinearRow toSlab = linearRow(map, cell, leaf, 0, PointMap::rowSlab);
    const NearView near(map, margin);
    std::size_t size = 0;
    for (std::size_t i = 0; i < count; i += hn::Lanes(floats)) {
        const Places places = loadPlaces(points + i, end);
        const Mask drawn = hn::FirstN(floats, count - i);
        size += near.store(toScreen(places), toSlab(places), drawn, out + size);
    }
    return size;
}

std::size_t projectPoints(const PointMap& map, LeafCell cell, const PackedPosition* points, std::size_t count,
                          const PackedPosition* end, float margin, ScreenPoint* out) {
    return map.perspective ? projectPointsOf<true>(map, cell, points, count, end, margin, out)
                           : projectPointsOf<false>(map, cell, points, count, end, margin, out);
}

template <bool perspective>
std::size_t projectPreviewOf(const PointMap& map, const PreviewRun& run, float margin, ScreenPoint* out) {
    const PreviewMap<perspective> preview(map);
    const auto toScreen = preview.toScreen(map);
    const LinearRow toSlab = preview.toSlab(map);
    const NearView near(map, margin);
    std::size_t size = 0;
    for (std::size_t i = 0; i < run.count; i += hn::Lanes(floats)) {
        const PreviewPlaces points = loadPreview(run, i);
        size += near.store(toScreen(points.places), toSlab(points.places), points.drawn, out + size);
    }
    return size;
}

std::size_t projectPreview(const PointMap& map, const PreviewRun& run, float margin, ScreenPoint* out) {
    return map.perspective ? projectPreviewOf<true>(map, run, margin, out)
                           : projectPreviewOf<false>(map, run, margin, out);
}

}  // namespace
}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace mote::render {

HWY_EXPORT(leafTiles);
HWY_EXPORT(gatherPoints);
HWY_EXPORT(projectPoints);
HWY_EXPORT(projectPreview);

void leafTiles(const PointMap& map, const LeafCell* cells, std::size_t count, float margin, TileBox* boxes) {
    HWY_DYNAMIC_DISPATCH(leafTiles)(map, cells, count, margin, boxes);
}

void gatherPoints(const PointMap& map, const LeafPoints* leaves, std::size_t count,
                  const storage::PackedPosition* points, const storage::PackedPosition* end, Tile tile,
                  TileCells& cells) {
    HWY_DYNAMIC_DISPATCH(gatherPoints)(map, leaves, count, points, end, tile, cells);
}

std::size_t projectPoints(const PointMap& map, LeafCell cell, const storage::PackedPosition* points,
                          std::size_t count, const storage::PackedPosition* end, float margin,
                          ScreenPoint* out) {
    return HWY_DYNAMIC_DISPATCH(projectPoints)(map, cell, points, count, end, margin, out);
}

std::size_t projectPreview(const PointMap& map, const PreviewRun& run, float margin, ScreenPoint* out) {
    return HWY_DYNAMIC_DISPATCH(projectPreview)(map, run, margin, out);
}

}  // namespace mote::render
#endif
