// SPDX-License-Identifier: GPL-3.0-or-later
//
// RangeBuilder: from the particles of one range of the plan, in the order of their rows, to its part of the
// octree, its points in the order of their leaves, and its part of the density volume. Its memory serves
// range after range; one thread each. Besides, pure functions: the volume and the manifest's densities.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "preprocess/particles/bounds_rule.h"
#include "preprocess/particles/cell_plan.h"
#include "protocol/scene/log_density.h"
#include "storage/particles/particle_step.h"

namespace mote::prep {

/// A point in its place among those of its leaf. As large as a Particle, whose place it takes.
struct LeafPoint {
    storage::PackedPosition position;
    std::uint16_t unused0 = 0;
    std::uint32_t row = 0;
    std::uint32_t unused1 = 0;
};
static_assert(sizeof(LeafPoint) == sizeof(Particle));

/// The particles' weights, or the one that all have.
struct Weights {
    std::span<const double> each;
    double all = 1.0;

    double operator[](std::size_t i) const { return each.empty() ? all : each[i]; }
};

/// The weight in a cell that holds any particle.
struct CellSum {
    double weight;
    std::uint64_t cell;  ///< its Morton key at cellLevel
};

struct RangeTree {
    std::vector<UnitTree> units;  ///< as in the plan
    OctreeLevels levels;          ///< below the grid's; the first one is gridLevel + 1
    std::vector<CellSum> cells;   ///< in Morton order
};

struct RangeOptions {
    OctreeOptions octree;
    unsigned gridLevel = 0;
    unsigned cellLevel = 0;  ///< of RangeTree::cells
};

class RangeBuilder {
  public:
    /// `particles` are those of `units`, whose numbers they agree with. The points are those of all units in
    /// turn, within a divided unit in Morton order of the leaves, within a leaf shuffled by their rows.
    RangeTree build(std::span<const Particle> particles, const Weights& weights,
                    std::span<const PlanUnit> units, const RangeOptions& options);

    /// The points of the range last built.
    std::span<const LeafPoint> points() const { return points_; }

  private:
    /// A cell that is divided: its particles among the sorted ones, its place in its level.
    struct Node {
        std::size_t begin, count, index;
    };
    using Split = std::array<std::size_t, 9>;
    struct Shuffled {
        std::uint64_t hash;
        std::uint32_t particle;
        bool operator<(const Shuffled& other) const { return hash < other.hash; }
    };

    void sort(std::span<const Particle> particles, unsigned keyLevel);
    void radixSort(unsigned from, unsigned bits);
    std::vector<CellSum> sumCells(unsigned shift) const;
    UnitTree divide(std::size_t begin, std::size_t count, RangeTree& tree, const RangeOptions& options,
                    unsigned keyLevel);
    Split split(const Node& node, unsigned shift) const;
    double finishLeaf(std::size_t begin, std::size_t count, unsigned level);
    void shuffle(std::size_t begin, std::size_t count);

    std::vector<std::uint64_t> packed_, other_;
    std::vector<std::uint64_t> keys_;  ///< ascending
    std::vector<Particle> sorted_;     ///< as many
    std::vector<double> weightStore_;  ///< as many, if they differ
    Weights weights_;
    std::vector<LeafPoint> points_;
    std::vector<Shuffled> shuffled_;
};

/// Adds the weights of cells at `cellLevel`, at least `level`, to those of their cells at `level`, by Morton
/// key.
void addCells(std::span<const CellSum> cells, unsigned cellLevel, unsigned level, std::vector<double>& sums);

/// The densities of the 8^level cells of an octree level, x fastest: weight over the cell's share of the box.
std::vector<float> densityVolume(const std::vector<double>& sums, unsigned level);

/// Adds particles to even bins of t over [0, 1], of which the last holds t = 1. `particles` are as many as
/// the leaves' densities; `bins` are resized to as many as the manifest has.
void addToHistogram(std::span<const float> density, std::span<const std::uint32_t> particles,
                    const LogDensity& scale, std::vector<std::uint64_t>& bins);

}  // namespace mote::prep
