// SPDX-License-Identifier: GPL-3.0-or-later
//
// BenchStep: a beam of many particles with an octree of even depth, made in a second or two: a dense core, a
// tenth of the particles as halo. For measuring only. Immutable; safe on any number of threads.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "storage/particles/particle_step.h"

namespace mote::bench {

class BenchStep final : public storage::ParticleStep {
  public:
    /// Leaves are the filled cells of `leafLevel`; the volume has 64 cells a side.
    BenchStep(std::uint64_t points, std::uint8_t leafLevel, std::uint64_t seed);

    storage::OctreeNodes nodes() const override;
    storage::Leaves leaves() const override;
    std::uint64_t pointCount() const override { return positions_.size(); }
    std::span<const storage::PackedPosition> positions(std::uint64_t begin,
                                                       std::uint64_t count) const override {
        return std::span(positions_).subspan(begin, count);
    }
    std::span<const std::uint64_t> rows(std::uint64_t, std::uint64_t) const override { return {}; }
    std::span<const float> volume() const override { return volume_; }
    std::uint32_t volumeSize() const override { return 64; }
    LogDensity logDensity() const override { return {leafDensity_.front(), leafDensity_.back()}; }

  private:
    struct Cell {
        std::uint64_t morton;
        std::uint64_t count;
        float minDensity;
        std::uint32_t first;  ///< its first child in the level below
        std::uint8_t children;
    };
    struct Point {
        std::uint64_t morton;  ///< of its leaf
        storage::PackedPosition position;
    };
    static std::vector<Cell> parentsOf(const std::vector<Cell>& children);
    void addLevel(const std::vector<Cell>& cells, std::uint8_t level, std::uint32_t firstBelow);
    void orderLeaves(const std::vector<Cell>& cells, std::uint32_t firstNode,
                     const std::vector<Point>& points);

    std::vector<std::uint8_t> level_, childCount_;
    std::vector<std::uint64_t> morton_, count_;
    std::vector<std::uint32_t> firstChild_;
    std::vector<float> density_, minDensity_;
    std::vector<std::uint32_t> leafNode_, leafCount_;
    std::vector<std::uint64_t> leafBegin_;
    std::vector<float> leafDensity_;
    std::vector<storage::PackedPosition> positions_;
    std::vector<float> volume_;
};

}  // namespace mote::bench
