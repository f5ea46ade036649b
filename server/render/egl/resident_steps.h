// SPDX-License-Identifier: GPL-3.0-or-later
//
// ResidentSteps: what a device keeps of steps in its memory, the least recently used given up first. It holds
// no step alive. Owned by the device; used while its context is current.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <optional>

#include "server/render/egl/step_points.h"
#include "server/render/egl/step_volume.h"

namespace mote::render {

struct ResidentStep {
    std::weak_ptr<const storage::ParticleStep> step;
    const storage::ParticleStep* key;
    StepPoints points;
    std::optional<StepVolume> volume;
    std::uint64_t volumeUse = 0;
};

class ResidentSteps {
  public:
    explicit ResidentSteps(std::uint64_t budget) : budget_(budget) {}

    /// Made where it is not there. The reference stays valid until dropExpired().
    ResidentStep& of(const std::shared_ptr<const storage::ParticleStep>& step);
    /// A chunk with the current selection; others are given up where the budget asks for it.
    const PointChunk& chunk(ResidentStep& resident, std::size_t index);
    /// Null where the frame is given up meanwhile.
    const StepVolume* volume(ResidentStep& resident, const Pacer& pacer);
    void dropExpired();
    std::uint64_t bytes() const;

  private:
    /// Gives up the least recently used until the budget is kept, but never what was used last.
    void makeRoom();

    std::uint64_t budget_;
    std::uint64_t uses_ = 0;
    std::list<ResidentStep> steps_;
};

}  // namespace mote::render
