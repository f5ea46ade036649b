// SPDX-License-Identifier: GPL-3.0-or-later
//
// SelectedStep: some points of a step as a step of their own, in memory: docs/PICTURE.md, "Selections". The
// octree is the step's without the cells that hold none of them, so that each point stays in its place to the
// last bit; densities and the volume are those of the chosen points; the density scale is the run's. It has
// no preview. Immutable; any number of threads. It does not hold the step that it was made from.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "storage/numbers/point_mask.h"
#include "storage/particles/particle_step.h"
#include "storage/step_origin.h"

namespace mote::storage {

class SelectedStep final : public ParticleStep {
  public:
    /// `mask`: of the step's points. `leafCapacity`: the manifest's. Stops with a `cancelled` error if
    /// `cancelled` says so. Uses all threads of the calling arena. Errors: resourceExhausted (a step of more
    /// than 2^32 points). Throws StorageError.
    static Result<std::shared_ptr<SelectedStep>> make(const ParticleStep& step, const PointMask& mask,
                                                      std::uint32_t leafCapacity,
                                                      const std::function<bool()>& cancelled);

    OctreeNodes nodes() const override {
        return {level_, morton_, firstChild_, childCount_, count_, density_, minDensity_};
    }
    Leaves leaves() const override { return {leafNode_, leafBegin_, leafCount_, leafDensity_}; }
    std::uint64_t pointCount() const override { return positions_.size(); }
    std::span<const PackedPosition> positions(std::uint64_t begin, std::uint64_t count) const override;
    /// Only of no points: rows are asked of the step, whose points sources() names.
    std::span<const std::uint64_t> rows(std::uint64_t begin, std::uint64_t count) const override;
    std::span<const float> volume() const override { return volume_; }
    std::uint32_t volumeSize() const override { return volumeSize_; }
    LogDensity logDensity() const override { return logDensity_; }

    /// Where it comes from, so that other processes can make the same: the file of the step, and the
    /// selection as a proto::Selection, serialised. Whoever makes it says so before it is shared.
    struct Origin {
        StepOrigin step;
        std::string selection;
    };
    std::optional<Origin> origin = std::nullopt;

    /// Which point of the step each one is.
    std::span<const std::uint32_t> sources() const { return sources_; }
    /// Of memory.
    std::uint64_t bytes() const;

  private:
    friend class StepSelector;

    std::vector<std::uint8_t> level_, childCount_;
    std::vector<std::uint64_t> morton_, count_;
    std::vector<std::uint32_t> firstChild_;
    std::vector<float> density_, minDensity_;
    std::vector<std::uint32_t> leafNode_, leafCount_;
    std::vector<std::uint64_t> leafBegin_;
    std::vector<float> leafDensity_;
    std::vector<PackedPosition> positions_;
    std::vector<std::uint32_t> sources_;
    std::vector<float> volume_;
    std::uint32_t volumeSize_ = 1;
    LogDensity logDensity_;
};

}  // namespace mote::storage
