// SPDX-License-Identifier: GPL-3.0-or-later
//
// HybridCache: the steps of hybrid volumes that were drawn last, loaded whole and kept. Their memory counts
// among the steps'. Owned by DatasetService; for the one thread that renders.
#pragma once

#include <list>
#include <memory>

#include "protocol/scene/error.h"
#include "server/render/hybrid/hybrid_step.h"
#include "server/session/step_cache.h"
#include "storage/catalogue.h"

namespace mote::server {

class HybridCache {
  public:
    static constexpr std::size_t mostSteps = 32;

    using Step = std::shared_ptr<const render::HybridStep>;

    /// `memory` must outlive it.
    explicit HybridCache(StepCache& memory) : memory_(memory) {}

    /// Loads it where it is not kept; where there is no room, what was drawn longest ago goes. Errors: as
    /// render::loadHybrid and hybridParts; invalidArgument (a dataset of another kind), resourceExhausted.
    Result<Step> step(const storage::Catalogue::Entry& entry, std::uint32_t index,
                      HybridRepresentation representation);

  private:
    struct Kept {
        std::shared_ptr<const proto::Manifest> manifest;  ///< tells a dataset from a later one of its name
        std::uint32_t index;
        HybridRepresentation representation;
        Step step;
        std::uint64_t bytes;
    };
    Status makeRoom(std::uint64_t bytes);
    void dropLast();

    StepCache& memory_;
    std::list<Kept> kept_;  // the latest first
};

}  // namespace mote::server
