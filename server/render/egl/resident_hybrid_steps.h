// SPDX-License-Identifier: GPL-3.0-or-later
//
// ResidentHybridSteps: what a device keeps of hybrid volumes in its memory, those given up first that were
// drawn longest ago. It holds no step alive. Owned by the device; used while its context is current.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <optional>

#include "server/render/cpu/resident_hybrids.h"
#include "server/render/egl/brick_looks.h"
#include "server/render/egl/step_hybrid.h"
#include "server/render/layers/hybrid/hybrid_plan.h"

namespace mote::render {

/// A step, and what pictures drew of it.
struct ResidentHybrid {
    std::weak_ptr<const HybridStep> step;
    const HybridStep* key;
    bool corrected;  ///< with bricks
    StepHybrid volume;
    struct Looks {
        HybridTransfer transfer;
        bool mixed;
        BrickLooks bricks;
    };
    std::list<Looks> looks = {};  ///< used last first

    std::size_t bytes() const { return volume.bytes(); }
};

/// What a layer draws: two may draw the same step.
struct HybridParts {
    ResidentHybrid* resident;
    const BrickLooks* bricks;
};

class ResidentHybridSteps {
  public:
    explicit ResidentHybridSteps(std::uint64_t budget) : budget_(budget) {}

    /// What the plan draws, ready but for light; empty where the frame is given up meanwhile. It stays valid
    /// for the next 15 calls, until dropExpired(). Throws DeviceError.
    std::optional<HybridParts> of(const HybridPlan& plan, const Pacer& pacer);
    void dropExpired();

  private:
    ResidentHybrid* find(const HybridPlan& plan, const Pacer& pacer);

    static constexpr std::size_t keptLooks = 16;  ///< more than a picture has layers

    std::uint64_t budget_;
    ResidentHybrids looks_;              // tables, and where the volumes are seen
    std::list<ResidentHybrid> hybrids_;  // drawn last first
};

}  // namespace mote::render
