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
#include <type_traits>
#include <utility>

#include "server/render/cpu/composite/disc_hits-inl.h"
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
        placeLeaves<perspective, false, false>(map, cells + begin, size, places);
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

/// Tile::pixelIndex of places within a tile: two bits of each tell the pixel in its packet, three the packet.
HWY_INLINE Int pixelIndex(Int x, Int y) {
    static_assert(Tile::edge == 32 && Tile::packetEdge == 4);
    const auto bits = [](Int from, std::int32_t mask) { return hn::And(from, hn::Set(ints, mask)); };
    const Int column = hn::Or(bits(x, 3), bits(hn::ShiftLeft<2>(x), 7 << 4));
    const Int row = hn::Or(bits(hn::ShiftLeft<2>(y), 3 << 2), bits(hn::ShiftLeft<5>(y), 7 << 7));
    return hn::Or(column, row);
}

/// The two sums of a PointCell or a PixelShade, to which is added at once.
using PairOfFloats = hn::CappedTag<float, 2>;
constexpr PairOfFloats pairs;
using Pair = hn::VFromD<PairOfFloats>;

HWY_INLINE Pair pairOf(float one, float other) {
    return hn::InterleaveLower(pairs, hn::Set(pairs, one), hn::Set(pairs, other));
}
HWY_INLINE void addPair(float* sums, Pair more) {
    hn::StoreU(hn::Add(hn::LoadU(pairs, sums), more), pairs, sums);
}

/// What a tile's points are added to.
struct CellSums {
    PointCell* cells;
    std::uint8_t* touched;

    /// `more`: as PointCell.
    HWY_INLINE void add(std::uint32_t cell, Pair more) const {
        addPair(&cells[cell].weight, more);
        touched[cell / Tile::packetPixels] = 1;
    }
};

/// What the levels of a tile's points are added to.
struct ShadeSums {
    PixelShade* shades;

    /// `cell`: of any slab. `more`: as PixelShade.
    HWY_INLINE void add(std::uint32_t cell, Pair more) const {
        addPair(&shades[cell % Tile::pixels].weight, more);
    }
};

/// Points on their way into cells. Some hundred are added in one loop, in their order: with a loop for each
/// vector, of as many steps as of it fall into the tile, points take 60% longer.
template <bool shaded>
class CellHits {
  public:
    CellHits(const CellSums& sums, const ShadeSums& shades) : sums_(sums), shades_(shades) {}

    /// Takes the first `count` lanes. `depth`: times weight.
    HWY_INLINE void take(Int cell, Float depth, Float level, std::size_t count) {
        hn::StoreU(cell, ints, cells_.data() + size_);
        hn::StoreU(depth, floats, depths_.data() + size_);
        if constexpr (shaded) hn::StoreU(level, floats, levels_.data() + size_);
        size_ += count;
    }
    HWY_INLINE bool full() const { return size_ > most; }

    /// Adds what was taken. `weight`: of each.
    HWY_NOINLINE void add(float weight) {
        // Copies: a byte that is written might be one of any member.
        const CellSums sums = sums_;
        const ShadeSums shades = shades_;
        for (std::size_t i = 0, size = std::exchange(size_, 0); i < size; ++i) {
            const auto cell = static_cast<std::uint32_t>(cells_[i]);
            sums.add(cell, pairOf(weight, depths_[i]));
            if constexpr (shaded) shades.add(cell, pairOf(1.0F, levels_[i]));
        }
    }

  private:
    static constexpr std::size_t most = 512;

    const CellSums sums_;
    const ShadeSums shades_;
    std::size_t size_ = 0;
    std::array<std::int32_t, most + mostLanes> cells_;
    std::array<float, most + mostLanes> depths_, levels_;
};

/// How deep the cells of a level lie, in slabs.
struct LevelDepth {
    float toMiddle;  ///< from where a cell's points begin, before it is bent
    float reach;     ///< from the middle, at most
};

std::array<LevelDepth, deepestLeafLevel + 1> levelDepths(const PointMap& map) {
    std::array<LevelDepth, deepestLeafLevel + 1> depths;
    double sum = 0.0, reach = 0.0;
    for (const auto& edge : map.edge) {
        sum += 0.5 * edge[PointMap::rowSlab];
        reach += 0.5 * std::abs(edge[PointMap::rowSlab]);
    }
    for (int level = 0; level <= static_cast<int>(deepestLeafLevel); ++level) {
        depths[static_cast<std::size_t>(level)] = {
            static_cast<float>(std::ldexp(sum, -level)),
            static_cast<float>(std::ldexp(reach, -level)) * map.bends.steepest()};
    }
    return depths;
}

/// Of a vector of points of a leaf, or of a group.
HWY_INLINE Float levelsOf(const LeafSource&, const LeafPoints& leaf, std::size_t) {
    return hn::Set(floats, static_cast<float>(leaf.level()));
}
HWY_INLINE Float levelsOf(const GroupSource& source, const LeafPoints& group, std::size_t first) {
    const hn::Rebind<std::uint8_t, Floats> bytes;
    return hn::ConvertTo(floats,
                         hn::PromoteTo(ints, hn::LoadU(bytes, source.levels + group.begin() + first)));
}

/// Places the leaves of a tile a block at a time, in `places`, and calls visit(leaf, its place in the block).
/// `told`: as for placeLeaves.
template <bool perspective, bool told, class Source, class Visit>
HWY_INLINE void visitLeaves(const PointMap& map, const LeafPoints* leaves, std::size_t count,
                            const Source& source, LeafPlaces& places, Visit visit) {
    constexpr std::size_t ahead = Source::ahead;
    HWY_ALIGN std::array<LeafCell, LeafPlaces::block> cells;
    for (std::size_t begin = 0; begin < count; begin += LeafPlaces::block) {
        const std::size_t size = std::min(LeafPlaces::block, count - begin);
        for (std::size_t i = 0; i < size; ++i) cells[i] = leaves[begin + i].cell;
        placeLeaves<perspective, true, told>(map, cells.data(), size, places);
        for (std::size_t i = 0; i < size; ++i) {
            if (begin + i + ahead < count) source.prefetch(leaves[begin + i + ahead].begin());
            visit(leaves[begin + i], i);
        }
    }
}

/// Adds the leaves, or groups, of one tile to its cells.
template <bool perspective, class Source, bool shaded>
class TileGather {
  public:
    TileGather(const PointMap& map, const Source& source, Tile tile, TileCells& cells)
        : map_(map),
          source_(source),
          left_(static_cast<float>(tile.column * Tile::edge)),
          top_(static_cast<float>(tile.row * Tile::edge)),
          slabs_(static_cast<float>(map.slabs())),
          sums_{cells.cells(), cells.touched()},
          shades_{cells.shades()},
          depths_(levelDepths(map)),
          hits_(sums_, shades_) {}

    void add(const LeafPoints* leaves, std::size_t count) {
        visitLeaves<perspective, std::is_same_v<Source, LeafSource>>(
            map_, leaves, count, source_, block_, [this](const LeafPoints& leaf, std::size_t i) {
                if constexpr (std::is_same_v<Source, LeafSource>) {
                    addLeaf(leaf, i);
                } else {
                    addGroup(leaf, i);
                }
            });
        if (count > 0) hits_.add(leaves[0].weight());  // groups weigh alike; of leaves none are left
    }

  private:
    HWY_INLINE void addGroup(const LeafPoints& group, std::size_t i) {
        // Points are rounded, by no more than this: they are to stay in the tile.
        constexpr float margin = 1.0F / 64.0F;
        constexpr float edge = Tile::edge;
        const bool inside = block_.left[i] >= left_ + margin && block_.right[i] <= left_ + edge - margin &&
                            block_.top[i] >= top_ + margin && block_.bottom[i] <= top_ + edge - margin;
        if (inside) {
            addEach<true>(group, i);
        } else {
            addEach<false>(group, i);
        }
    }

    HWY_INLINE void addLeaf(const LeafPoints& leaf, std::size_t i) {
        const LevelDepth& depth = depths_[cellLevel(leaf.cell)];
        const float middle = map_.bends(block_.origin[PointMap::rowSlab][i] + depth.toMiddle);
        const float slab = std::floor(middle);
        const float left = std::floor(block_.left[i]), top = std::floor(block_.top[i]);
        // A cell that is flat in its slab has its points' mean depth at its middle, or as good as there.
        constexpr float flat = 1.0F / 8.0F;
        if (depth.reach < flat && middle - depth.reach >= slab && middle + depth.reach < slab + 1.0F &&
            slab >= 0.0F && slab < slabs_ && block_.right[i] < left + 2.0F && block_.bottom[i] < top + 2.0F &&
            left >= left_ && top >= top_ && left + 2.0F <= left_ + Tile::edge &&
            top + 2.0F <= top_ + Tile::edge) {
            addToFour(leaf, i, left, top, slab, middle - slab);
        } else {
            addEach<false>(leaf, i);
            hits_.add(leaf.weight());
        }
    }

    /// As countInFour of the flat counts.
    HWY_INLINE void addToFour(const LeafPoints& leaf, std::size_t i, float left, float top, float slab,
                              float place) {
        const Quarters quarters =
            countQuarters(block_, i, source_.points + leaf.begin(), leaf.count(), source_.end);
        const auto x = static_cast<std::uint32_t>(left - left_), y = static_cast<std::uint32_t>(top - top_);
        const std::uint32_t first = static_cast<std::uint32_t>(slab) * Tile::pixels;
        const auto addTo = [&](std::uint32_t column, std::uint32_t row, std::size_t count) {
            if (count == 0) return;
            const float weight = static_cast<float>(count) * leaf.weight();
            const std::uint32_t pixel = Tile::pixelIndex(column, row);
            sums_.add(first + pixel, pairOf(weight, weight * place));
            if constexpr (shaded) {
                const auto points = static_cast<float>(count);
                shades_.add(pixel, pairOf(points, points * static_cast<float>(leaf.level())));
            }
        };
        addTo(x, y, quarters.leftTop);
        addTo(x + 1, y, quarters.rightTop);
        addTo(x, y + 1, quarters.leftBottom);
        addTo(x + 1, y + 1, quarters.rightBottom);
    }

    /// `inside`: all lie in the tile.
    template <bool inside>
    HWY_INLINE void addEach(const LeafPoints& leaf, std::size_t i) {
        static_assert(Tile::edge == 32 && Tile::packetEdge == 4 && Tile::pixels == 1 << 10);
        const LeafMap<perspective> toScreen(map_, leaf.cell, block_, i, Source::scale);
        const SlabRow toSlab = slabRow(map_, leaf.cell, block_, i, Source::scale);
        const Float zero = hn::Zero(floats), edge = hn::Set(floats, static_cast<float>(Tile::edge));
        const Int lastSlab = hn::Set(ints, static_cast<std::int32_t>(map_.slabs()) - 1);
        const std::size_t count = leaf.count();
        const Float weight = hn::Set(floats, leaf.weight());
        for (std::size_t k = 0; k < count; k += hn::Lanes(floats)) {
            const Places at = source_.load(leaf.begin() + k);
            const Projected pixel = toScreen(at);
            const Float x = hn::Sub(pixel.x, hn::Set(floats, left_)),
                        y = hn::Sub(pixel.y, hn::Set(floats, top_));
            const Float slab = hn::Min(hn::Max(toSlab(at), zero), hn::Set(floats, slabs_));
            const Int slabIndex = hn::Min(truncated(floats, slab), lastSlab);
            const Int cell =
                hn::Or(hn::ShiftLeft<10>(slabIndex), pixelIndex(truncated(floats, x), truncated(floats, y)));
            const Float depth = hn::Mul(weight, hn::Sub(slab, hn::ConvertTo(floats, slabIndex)));
            const Float level = shaded ? levelsOf(source_, leaf, k) : zero;
            if constexpr (inside) {
                hits_.take(cell, depth, level, std::min(count - k, hn::Lanes(floats)));
            } else {
                const Mask inX = hn::And(hn::Ge(x, zero), hn::Lt(x, edge));
                const Mask inY = hn::And(hn::Ge(y, zero), hn::Lt(y, edge));
                const Mask seen =
                    hn::And(hn::And(inX, inY), hn::And(pixel.seen, hn::FirstN(floats, count - k)));
                hits_.take(hn::Compress(cell, hn::RebindMask(ints, seen)), hn::Compress(depth, seen),
                           hn::Compress(level, seen), hn::CountTrue(floats, seen));
            }
            if (HWY_UNLIKELY(hits_.full())) hits_.add(leaf.weight());
        }
    }

    const PointMap& map_;
    const Source source_;
    const float left_, top_;  // of the tile, pixels
    const float slabs_;
    const CellSums sums_;
    const ShadeSums shades_;
    const std::array<LevelDepth, deepestLeafLevel + 1> depths_;
    LeafPlaces block_;
    CellHits<shaded> hits_;
};

template <bool perspective, class Source>
void gatherFrom(const PointMap& map, const LeafPoints* leaves, std::size_t count, const Source& source,
                Tile tile, TileCells& cells) {
    if (cells.shaded()) {
        TileGather<perspective, Source, true>(map, source, tile, cells).add(leaves, count);
    } else {
        TileGather<perspective, Source, false>(map, source, tile, cells).add(leaves, count);
    }
}

template <class Source>
void gatherFrom(const PointMap& map, const LeafPoints* leaves, std::size_t count, const Source& source,
                Tile tile, TileCells& cells) {
    if (map.perspective) {
        gatherFrom<true>(map, leaves, count, source, tile, cells);
    } else {
        gatherFrom<false>(map, leaves, count, source, tile, cells);
    }
}

void gatherPoints(const PointMap& map, const LeafPoints* leaves, std::size_t count,
                  const PackedPosition* points, const PackedPosition* end, Tile tile, TileCells& cells) {
    gatherFrom(map, leaves, count, LeafSource{points, end}, tile, cells);
}

void gatherGrouped(const PointMap& map, const LeafPoints* groups, std::size_t count,
                   const GroupedPoint* points, const std::uint8_t* levels, Tile tile, TileCells& cells) {
    gatherFrom(map, groups, count, GroupSource{points, levels}, tile, cells);
}

template <bool perspective, bool shaded, class Source>
void gatherDiscsOf(const PointMap& map, const LeafPoints* leaves, std::size_t count, const Source& source,
                   const DiscFootprint& disc, Tile tile, TileCells& cells) {
    DiscHits<shaded> hits(disc, tile, cells);
    const NearBox near(hits.box(), disc.reach());
    const Float farthest = hn::Set(floats, static_cast<float>(map.slabs()));
    LeafPlaces places;
    visitLeaves<perspective, false>(
        map, leaves, count, source, places, [&](const LeafPoints& leaf, std::size_t i) {
            const LeafMap<perspective> toScreen(map, leaf.cell, places, i, Source::scale);
            const SlabRow toSlab = slabRow(map, leaf.cell, places, i, Source::scale);
            hits.setWeight(leaf.weight());
            for (std::size_t k = 0; k < leaf.count(); k += hn::Lanes(floats)) {
                const Places at = source.load(leaf.begin() + k);
                const Projected pixel = toScreen(at);
                const Mask seen = near(pixel, hn::FirstN(floats, leaf.count() - k));
                const Float slab = hn::Min(hn::Max(toSlab(at), hn::Zero(floats)), farthest);
                const Float level = shaded ? levelsOf(source, leaf, k) : slab;
                hits.take(pixel.x, pixel.y, slab, level, seen);
            }
        });
    hits.finish();
}

template <class Source>
void gatherDiscsFrom(const PointMap& map, const LeafPoints* leaves, std::size_t count, const Source& source,
                     const DiscFootprint& disc, Tile tile, TileCells& cells) {
    const auto gather = [&](auto perspective, auto shaded) {
        gatherDiscsOf<perspective(), shaded()>(map, leaves, count, source, disc, tile, cells);
    };
    const auto gatherMapped = [&](auto perspective) {
        cells.shaded() ? gather(perspective, std::true_type()) : gather(perspective, std::false_type());
    };
    map.perspective ? gatherMapped(std::true_type()) : gatherMapped(std::false_type());
}

void gatherDiscs(const PointMap& map, const LeafPoints* leaves, std::size_t count,
                 const PackedPosition* points, const PackedPosition* end, const DiscFootprint& disc,
                 Tile tile, TileCells& cells) {
    gatherDiscsFrom(map, leaves, count, LeafSource{points, end}, disc, tile, cells);
}

void gatherGroupedDiscs(const PointMap& map, const LeafPoints* groups, std::size_t count,
                        const GroupedPoint* points, const std::uint8_t* levels, const DiscFootprint& disc,
                        Tile tile, TileCells& cells) {
    gatherDiscsFrom(map, groups, count, GroupSource{points, levels}, disc, tile, cells);
}

template <bool shaded>
void gatherScreenDiscsOf(const ScreenPoint* points, std::size_t count, const DiscFootprint& disc, Tile tile,
                         TileCells& cells) {
    DiscHits<shaded> hits(disc, tile, cells);
    const NearBox near(hits.box(), disc.reach());
    HWY_ALIGN std::array<ScreenPoint, mostLanes> tail{};
    for (std::size_t i = 0; i < count; i += hn::Lanes(floats)) {
        const ScreenPoint* from = points + i;
        if (count - i < hn::Lanes(floats)) {
            std::copy_n(from, count - i, tail.begin());
            from = tail.data();
        }
        Float x, y, slab, level;
        static_assert(sizeof(ScreenPoint) == 4 * sizeof(float));
        hn::LoadInterleaved4(floats, &from->x, x, y, slab, level);
        const Mask seen = near({x, y, hn::Eq(x, x)}, hn::FirstN(floats, count - i));
        hits.take(x, y, slab, level, seen);
    }
    hits.finish();
}

void gatherScreenDiscs(const ScreenPoint* points, std::size_t count, const DiscFootprint& disc, Tile tile,
                       TileCells& cells) {
    if (cells.shaded()) {
        gatherScreenDiscsOf<true>(points, count, disc, tile, cells);
    } else {
        gatherScreenDiscsOf<false>(points, count, disc, tile, cells);
    }
}

/// Keeps the points of a vector that lie within a margin of the picture.
struct NearView {
    NearBox near;
    Float farthest;

    HWY_INLINE NearView(const PointMap& map, float margin)
        : near(pictureOf(map), margin), farthest(hn::Set(floats, static_cast<float>(map.slabs()))) {}

    HWY_INLINE std::size_t store(const Projected& at, Float slab, Float level, Mask drawn,
                                 ScreenPoint* out) const {
        const Mask seen = near(at, drawn);
        HWY_ALIGN std::array<float, mostLanes> xs, ys, slabs, levels;
        const std::size_t hits = storePacked(floats, at.x, seen, xs.data());
        storePacked(floats, at.y, seen, ys.data());
        storePacked(floats, hn::Min(hn::Max(slab, hn::Zero(floats)), farthest), seen, slabs.data());
        storePacked(floats, level, seen, levels.data());
        for (std::size_t hit = 0; hit < hits; ++hit) out[hit] = {xs[hit], ys[hit], slabs[hit], levels[hit]};
        return hits;
    }
};

template <bool perspective>
std::size_t projectPointsOf(const PointMap& map, LeafCell cell, const PackedPosition* points,
                            std::size_t count, const PackedPosition* end, float margin, ScreenPoint* out) {
    LeafPlaces leaf;
    placeLeaves<perspective>(map, &cell, 1, leaf);
    const LeafMap<perspective> toScreen(map, cell, leaf, 0);
    const SlabRow toSlab = slabRow(map, cell, leaf, 0);
    const NearView near(map, margin);
    std::size_t size = 0;
    for (std::size_t i = 0; i < count; i += hn::Lanes(floats)) {
        const Places places = loadPlaces(points + i, end);
        const Mask drawn = hn::FirstN(floats, count - i);
        size += near.store(toScreen(places), toSlab(places), hn::Zero(floats), drawn, out + size);
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
    const SlabRow toSlab = preview.toSlab(map);
    const NearView near(map, margin);
    std::size_t size = 0;
    for (std::size_t i = 0; i < run.count; i += hn::Lanes(floats)) {
        const PreviewPlaces points = loadPreview(run, i);
        size += near.store(toScreen(points.places), toSlab(points.places),
                           hn::ConvertTo(floats, points.level), points.drawn, out + size);
    }
    return size;
}

std::size_t projectPreview(const PointMap& map, const PreviewRun& run, float margin, ScreenPoint* out) {
    return map.perspective ? projectPreviewOf<true>(map, run, margin, out)
                           : projectPreviewOf<false>(map, run, margin, out);
}

/// Stores the chosen lanes side by side; returns how many. `whole`: a whole vector has room there.
HWY_INLINE std::size_t storeSeen(Int values, hn::Mask<Ints> seen, bool whole, std::uint32_t* out) {
    auto* const at = reinterpret_cast<std::int32_t*>(out);
    return whole ? storePacked(ints, values, seen, at) : hn::CompressBlendedStore(values, seen, ints, at);
}

template <bool perspective>
std::size_t packPreviewOf(const PointMap& map, const PreviewRun& run, std::uint32_t columns,
                          std::uint32_t* tiles, TilePoint* points) {
    const PreviewMap<perspective> preview(map);
    const auto toScreen = preview.toScreen(map);
    const SlabRow toSlab = preview.toSlab(map);
    const Float zero = hn::Zero(floats), width = hn::Set(floats, static_cast<float>(map.width)),
                height = hn::Set(floats, static_cast<float>(map.height));
    const Int lastInTile = hn::Set(ints, Tile::edge - 1);
    const Int lastPlace = hn::Set(ints, static_cast<std::int32_t>(map.slabs() << placeBits) - 1);
    const Int tileColumns = hn::Set(ints, static_cast<std::int32_t>(columns));
    const Int placeMask = hn::Set(ints, (1 << placeBits) - 1);
    std::size_t size = 0;
    for (std::size_t i = 0; i < run.count; i += hn::Lanes(floats)) {
        const PreviewPlaces at = loadPreview(run, i);
        const Projected pixel = toScreen(at.places);
        const Mask inX = hn::And(hn::Ge(pixel.x, zero), hn::Lt(pixel.x, width));
        const Mask inY = hn::And(hn::Ge(pixel.y, zero), hn::Lt(pixel.y, height));
        const Mask seen = hn::And(hn::And(inX, inY), hn::And(pixel.seen, at.drawn));
        const Int x = hn::ConvertTo(ints, pixel.x), y = hn::ConvertTo(ints, pixel.y);
        const Int tile = hn::Add(hn::Mul(hn::ShiftRight<5>(y), tileColumns), hn::ShiftRight<5>(x));
        // The slab and the place in it are one fixed-point number.
        const Float depth = hn::Mul(toSlab(at.places), hn::Set(floats, static_cast<float>(1 << placeBits)));
        const Int deep = hn::Min(hn::ConvertTo(ints, hn::Max(depth, zero)), lastPlace);
        const Int inTile = pixelIndex(hn::And(x, lastInTile), hn::And(y, lastInTile));
        const Int cell = hn::Add(hn::ShiftLeft<10>(hn::ShiftRight<placeBits>(deep)), inTile);
        const Int place = hn::Or(hn::ShiftLeft<placeBits>(cell), hn::And(deep, placeMask));
        const Int packed = hn::Or(hn::ShiftLeft<levelBits>(place), at.level);
        const auto mask = hn::RebindMask(ints, seen);
        const bool whole = i + hn::Lanes(floats) <= run.count;
        storeSeen(packed, mask, whole, points + size);
        size += storeSeen(tile, mask, whole, tiles + size);
    }
    return size;
}

std::size_t packPreview(const PointMap& map, const PreviewRun& run, std::uint32_t columns,
                        std::uint32_t* tiles, TilePoint* points) {
    return map.perspective ? packPreviewOf<true>(map, run, columns, tiles, points)
                           : packPreviewOf<false>(map, run, columns, tiles, points);
}

}  // namespace
}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace mote::render {

HWY_EXPORT(leafTiles);
HWY_EXPORT(gatherPoints);
HWY_EXPORT(gatherGrouped);
HWY_EXPORT(gatherDiscs);
HWY_EXPORT(gatherGroupedDiscs);
HWY_EXPORT(gatherScreenDiscs);
HWY_EXPORT(projectPoints);
HWY_EXPORT(projectPreview);
HWY_EXPORT(packPreview);

void leafTiles(const PointMap& map, const LeafCell* cells, std::size_t count, float margin, TileBox* boxes) {
    HWY_DYNAMIC_DISPATCH(leafTiles)(map, cells, count, margin, boxes);
}

void gatherPoints(const PointMap& map, const LeafPoints* leaves, std::size_t count,
                  const storage::PackedPosition* points, const storage::PackedPosition* end, Tile tile,
                  TileCells& cells) {
    HWY_DYNAMIC_DISPATCH(gatherPoints)(map, leaves, count, points, end, tile, cells);
}

void gatherDiscs(const PointMap& map, const LeafPoints* leaves, std::size_t count,
                 const storage::PackedPosition* points, const storage::PackedPosition* end,
                 const DiscFootprint& disc, Tile tile, TileCells& cells) {
    HWY_DYNAMIC_DISPATCH(gatherDiscs)(map, leaves, count, points, end, disc, tile, cells);
}

void gatherGrouped(const PointMap& map, const LeafPoints* groups, std::size_t count,
                   const GroupedPoint* points, const std::uint8_t* levels, Tile tile, TileCells& cells) {
    HWY_DYNAMIC_DISPATCH(gatherGrouped)(map, groups, count, points, levels, tile, cells);
}

void gatherGroupedDiscs(const PointMap& map, const LeafPoints* groups, std::size_t count,
                        const GroupedPoint* points, const std::uint8_t* levels, const DiscFootprint& disc,
                        Tile tile, TileCells& cells) {
    HWY_DYNAMIC_DISPATCH(gatherGroupedDiscs)(map, groups, count, points, levels, disc, tile, cells);
}

void gatherScreenDiscs(const ScreenPoint* points, std::size_t count, const DiscFootprint& disc, Tile tile,
                       TileCells& cells) {
    HWY_DYNAMIC_DISPATCH(gatherScreenDiscs)(points, count, disc, tile, cells);
}

std::size_t projectPoints(const PointMap& map, LeafCell cell, const storage::PackedPosition* points,
                          std::size_t count, const storage::PackedPosition* end, float margin,
                          ScreenPoint* out) {
    return HWY_DYNAMIC_DISPATCH(projectPoints)(map, cell, points, count, end, margin, out);
}

std::size_t projectPreview(const PointMap& map, const PreviewRun& run, float margin, ScreenPoint* out) {
    return HWY_DYNAMIC_DISPATCH(projectPreview)(map, run, margin, out);
}

std::size_t packPreview(const PointMap& map, const PreviewRun& run, std::uint32_t columns,
                        std::uint32_t* tiles, TilePoint* points) {
    return HWY_DYNAMIC_DISPATCH(packPreview)(map, run, columns, tiles, points);
}

}  // namespace mote::render
#endif
