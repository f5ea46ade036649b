// SPDX-License-Identifier: GPL-3.0-or-later
//
// ResidentHybridSteps: what a device keeps of hybrid volumes in its memory, those given up first that were
// drawn longest ago. It holds no step alive. Owned by the device; used while its context is current.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <optional>

#include "server/render/egl/step_hybrid.h"
#include "server/render/egl/step_splats.h"
#include "server/render/hybrid/hybrid_plan.h"

namespace mote::render {

/// A step and what the last picture drew of it.
struct ResidentHybrid {
    std::weak_ptr<const HybridStep> step;
    const HybridStep* key;
    bool corrected;  ///< with bricks
    StepHybrid volume;
    std::optional<StepSplats> splats;
    std::optional<HybridTransfer> transfer;  ///< for which all below is
    std::vector<std::uint32_t> brickWords = {};
    std::vector<std::uint32_t> visible = {};  ///< bricks in which something is seen, x | y << 10 | z << 20

    std::size_t bytes() const { return volume.bytes() + (splats ? splats->bytes() : 0); }
};

class ResidentHybridSteps {
  public:
    explicit ResidentHybridSteps(std::uint64_t budget) : budget_(budget) {}

    /// What the plan draws, ready but for light; null where the frame is given up meanwhile. It stays valid
    /// until dropExpired(). Throws DeviceError.
    ResidentHybrid* of(const HybridPlan& plan, const TransferTable& table, const Pacer& pacer);
    void dropExpired();

  private:
    ResidentHybrid* find(const HybridPlan& plan, const Pacer& pacer);

    std::uint64_t budget_;
    std::list<ResidentHybrid> hybrids_;  // drawn last first
};

}  // namespace mote::render
