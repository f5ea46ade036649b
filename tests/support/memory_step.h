// SPDX-License-Identifier: GPL-3.0-or-later
//
// MemoryStep: a particle step without files, for tests. It is built from plain points by a slow, simple
// octree builder that shares no code with mote-prep, so that a test of the renderers does not lean on the
// job, and may hold leaves and a volume that no particles would make. Immutable; safe on any number of
// threads.
#pragma once

#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "storage/particles/particle_step.h"

namespace mote::test {

// The preview of any step, by sorting all of its points: slow, and of no code that mote-prep uses. A pure
// function.

struct BrutePreview {
    std::vector<storage::PreviewPoint> points;
    std::vector<float> threshold;
    LogDensity scale;

    /// As ParticleStep::preview.
    storage::Preview first(std::uint64_t most) const;
};

BrutePreview brutePreview(const storage::ParticleStep& step);

struct WeightedPoint {
    glm::dvec3 position;  ///< in the plot's box [0, 1]^3
    double weight = 1.0;  ///< > 0
};

struct MemoryStepOptions {
    std::uint32_t leafCapacity = 64;  ///< a fuller cell is split, down to maxLevel
    std::uint8_t maxLevel = 10;       ///< at most 20
    std::uint8_t volumeLevel = 5;     ///< the volume has 2^volumeLevel cells along each axis
    std::uint64_t seed = 1;           ///< of the shuffle within leaves
    std::optional<LogDensity> logDensity =
        std::nullopt;  ///< absent: from the least and the greatest leaf density
    /// Replaces the counted volume unless empty, x fastest. Where any of it is above 0, the leaves are its
    /// cells, of these densities, whatever points lie in them.
    std::vector<float> volume = {};
};

class MemoryStep final : public storage::ParticleStep {
  public:
    /// Points outside the box are a broken invariant. No points: a root without leaves.
    static std::shared_ptr<const MemoryStep> make(const std::vector<WeightedPoint>& points,
                                                  const MemoryStepOptions& options = {});

    storage::OctreeNodes nodes() const override;
    storage::Leaves leaves() const override;
    std::uint64_t pointCount() const override { return positions_.size(); }
    std::span<const storage::PackedPosition> positions(std::uint64_t begin,
                                                       std::uint64_t count) const override;
    std::span<const std::uint64_t> rows(std::uint64_t begin, std::uint64_t count) const override;
    std::span<const float> volume() const override { return volume_; }
    std::uint32_t volumeSize() const override { return volumeSize_; }
    storage::Preview preview(std::uint64_t most) const override { return preview_.first(most); }
    LogDensity logDensity() const override { return logDensity_; }

  private:
    friend class MemoryStepBuilder;

    std::vector<std::uint8_t> level_;
    std::vector<std::uint64_t> morton_;
    std::vector<std::uint32_t> firstChild_;
    std::vector<std::uint8_t> childCount_;
    std::vector<std::uint64_t> count_;
    std::vector<float> density_;
    std::vector<float> minDensity_;

    std::vector<std::uint32_t> leafNode_;
    std::vector<std::uint64_t> leafBegin_;
    std::vector<std::uint32_t> leafCount_;
    std::vector<float> leafDensity_;

    std::vector<storage::PackedPosition> positions_;
    std::vector<std::uint64_t> rows_;
    std::vector<float> volume_;
    std::uint32_t volumeSize_ = 1;
    BrutePreview preview_;
    LogDensity logDensity_;
};

}  // namespace mote::test
