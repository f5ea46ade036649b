// SPDX-License-Identifier: GPL-3.0-or-later
//
// ResidentHybrids: what the device keeps of hybrid volumes and of their transfer functions: tables, ranges of
// values by block, and where a volume is visible. It holds no step alive. Owned by the device, used on its
// thread; what it returns may be read by any number until the next picture.
#pragma once

#include <list>
#include <memory>

#include "server/render/cpu/composite_frame.h"

namespace mote::render {

/// The range of values in blocks of 8 cells of the grid that rays go by: the error grid where the volume is
/// drawn corrected, the low volume otherwise. Corrected bricks are fine. `mixed`: the low volume shows in
/// them, too. Works in parallel.
BlockRanges hybridRanges(const HybridStep& step, bool corrected, bool mixed);

class ResidentHybrids {
  public:
    /// Works in parallel.
    VisibleHybrid of(const HybridPlan& plan);
    /// Gives up what belongs to steps that nobody else holds any more.
    void dropExpired();

  private:
    struct Table {
        HybridTransfer transfer;
        VolumeTable table;
    };
    struct Visible {
        HybridTransfer transfer;
        VisibleBlocks blocks;
    };
    struct Resident {
        std::weak_ptr<const HybridStep> step;
        const HybridStep* key;
        bool corrected, mixed;
        BlockRanges ranges;
        std::list<Visible> visible;  ///< used last first
    };
    static constexpr std::size_t kept = 16;  ///< more than a picture has layers

    const VolumeTable& table(const HybridTransfer& transfer);
    Resident& resident(const HybridPlan& plan);

    std::list<Table> tables_;  ///< used last first
    std::list<Resident> volumes_;
};

}  // namespace mote::render
