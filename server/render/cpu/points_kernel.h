// SPDX-License-Identifier: GPL-3.0-or-later
//
// The inner loops over points, compiled for each instruction set and chosen at run time. Pure functions on
// the memory they are given; any thread.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "server/render/cpu/leaf_cells.h"
#include "server/render/cpu/point_footprint.h"
#include "server/render/cpu/point_map.h"
#include "server/render/cpu/tile_cells.h"
#include "server/render/plan/point_values.h"
#include "server/render/plan/preview_selection.h"
#include "storage/particles/particle_step.h"

namespace mote::render {

/// Leaves in the order of the file.
struct LeafRun {
    const LeafCell* cells = nullptr;
    const std::uint32_t* drawn = nullptr;             ///< by leaf, at most its count
    const std::uint32_t* count = nullptr;             ///< by leaf
    const storage::PackedPosition* points = nullptr;  ///< of the first leaf; the others follow
    const storage::PackedPosition* end = nullptr;     ///< of what may be read
    std::size_t leaves = 0;
};

/// Counts that are kept behind those of the pixels, for the lanes of a vector that shall count nowhere.
inline constexpr std::size_t spareCounts = 64;

/// Where depth does not matter, more points are not seen in a pixel that holds so much: leaves all of whose
/// pixels do are not read.
using FullCount = std::uint32_t;
inline constexpr FullCount neverFull = ~FullCount{0};

/// Adds one to the pixel of each point in view, counts[y * width + x], behind which there are spareCounts
/// more; pixels that are full may get less. Returns how many points were drawn, but for leaves out of view.
std::uint64_t countPoints(const PointMap& map, const LeafRun& run, FullCount full, std::uint32_t* counts);

/// What discs add where depth does not matter.
struct FlatDiscs {
    float reach;                                                ///< as DiscFootprint's
    std::array<std::uint32_t, DiscFootprint::steps + 1> units;  ///< by coverage, at most 2^31
};

/// The same of discs: adds to each pixel what they cover of it. No count exceeds 2^32 - 1.
std::uint64_t countDiscs(const PointMap& map, const LeafRun& run, const FlatDiscs& discs, FullCount full,
                         std::uint32_t* counts);

/// Tiles [left, right) x [top, bottom).
struct TileBox {
    std::uint16_t left = 0, top = 0, right = 0, bottom = 0;
};

/// The tiles that each leaf's points can touch, which reach `margin` pixels around them; none where it is out
/// of view.
void leafTiles(const PointMap& map, const LeafCell* cells, std::size_t count, float margin, TileBox* boxes);

/// A run of points of one leaf, or of one group.
struct LeafPoints {
    LeafCell cell;  ///< bits from `countShift` hold the number of points
    /// Its first point; bits from `levelShift` hold the level of its points (DensityLevels), those from
    /// `weightShift` the upper half of what each point weighs.
    std::uint64_t weighted;

    static constexpr unsigned countShift = 53, levelShift = 40, weightShift = 48;
    static constexpr std::uint64_t mostPoints = (std::uint64_t{1} << (64 - countShift)) - 1;
    static constexpr std::uint16_t one = 0x3f80;  ///< a weight

    static LeafPoints of(LeafCell cell, std::uint64_t count, std::uint64_t begin, std::uint8_t level = 0,
                         std::uint16_t weight = one) {
        return {cell | count << countShift,
                begin | std::uint64_t{level} << levelShift | std::uint64_t{weight} << weightShift};
    }
    std::uint32_t count() const { return static_cast<std::uint32_t>(cell >> countShift); }
    std::uint64_t begin() const { return weighted & ((std::uint64_t{1} << levelShift) - 1); }
    std::uint8_t level() const { return static_cast<std::uint8_t>(weighted >> levelShift); }
    float weight() const {
        return std::bit_cast<float>(static_cast<std::uint32_t>(weighted >> weightShift) << 16);
    }
};

/// Adds each point that falls into the tile to its cell with its weight.
void gatherPoints(const PointMap& map, const LeafPoints* leaves, std::size_t count,
                  const storage::PackedPosition* points, const storage::PackedPosition* end, Tile tile,
                  TileCells& cells);

/// A point of a group (point_groups.h): its place in the group's cell, the cell's edge being 2^21, 21 bits
/// each for x, from bit 0 of `low`, y and z, to the last bit of `high`.
struct GroupedPoint {
    std::uint32_t low, high;
};
/// Behind the last one are so many more, as vectors of them are read.
inline constexpr std::size_t sparePoints = 16;

/// gatherPoints of groups. `levels`: by point, as many; null: they have none.
void gatherGrouped(const PointMap& map, const LeafPoints* groups, std::size_t count,
                   const GroupedPoint* points, const std::uint8_t* levels, Tile tile, TileCells& cells);

/// A point on the screen.
struct ScreenPoint {
    float x, y;          ///< pixels
    float slab;          ///< from the layer's first on, 0 to PointMap::slabs
    float level = 0.0F;  ///< DensityLevels; of points of a preview or a stream
};

/// countDiscs of points on the screen.
void countScreenDiscs(const PointMap& map, const ScreenPoint* points, std::size_t count,
                      const FlatDiscs& discs, std::uint32_t* counts);

/// Adds what each disc covers of the tile's pixels, times its weight, to their cells.
void gatherDiscs(const PointMap& map, const LeafPoints* leaves, std::size_t count,
                 const storage::PackedPosition* points, const storage::PackedPosition* end,
                 const DiscFootprint& disc, Tile tile, TileCells& cells);

/// gatherDiscs of groups.
void gatherGroupedDiscs(const PointMap& map, const LeafPoints* groups, std::size_t count,
                        const GroupedPoint* points, const std::uint8_t* levels, const DiscFootprint& disc,
                        Tile tile, TileCells& cells);

/// The same of points on the screen, each of weight 1.
void gatherScreenDiscs(const ScreenPoint* points, std::size_t count, const DiscFootprint& disc, Tile tile,
                       TileCells& cells);

/// The points of one run that lie within `margin` pixels of the picture, in their order; `out` has room for
/// `count`. Returns how many there are.
std::size_t projectPoints(const PointMap& map, LeafCell cell, const storage::PackedPosition* points,
                          std::size_t count, const storage::PackedPosition* end, float margin,
                          ScreenPoint* out);

/// A block of the preview: its points are drawn where the limit of their density (PreviewSelection::limit)
/// is at least `threshold`.
struct PreviewRun {
    const storage::PreviewPoint* points = nullptr;
    std::size_t count = 0;
    const float* limit = nullptr;
    float threshold = 0.0F;
    LevelLine levels = {};  ///< of their densities
};

/// As countPoints.
std::uint64_t countPreview(const PointMap& map, const PreviewRun& run, std::uint32_t* counts);

/// As projectPoints.
std::size_t projectPreview(const PointMap& map, const PreviewRun& run, float margin, ScreenPoint* out);

/// A point of no more than a pixel, packed: its cell in its tile, slab * Tile::pixels + Tile::pixelIndex, how
/// deep in the slab, in 2^-placeBits, and its level (ScreenPoint), in the last levelBits. Slabs from the
/// layer's first on.
using TilePoint = std::uint32_t;
inline constexpr unsigned placeBits = 4, levelBits = 8;
static_assert(mostSlabs * Tile::pixels <= std::uint32_t{1} << (32 - placeBits - levelBits));

/// As projectPreview of the points that fall into the picture: the tile of each, row by row in `columns`, and
/// what it is there. Both have room for the run's count.
std::size_t packPreview(const PointMap& map, const PreviewRun& run, std::uint32_t columns,
                        std::uint32_t* tiles, TilePoint* points);

}  // namespace mote::render
