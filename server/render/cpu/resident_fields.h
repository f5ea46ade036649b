// SPDX-License-Identifier: GPL-3.0-or-later
//
// ResidentFields: what the device keeps of fields of either kind of samples: packed volumes, transfer tables,
// and where they are visible. It holds no data alive. Owned by the device, used on its thread; what it
// returns may be read by any number until the next picture.
#pragma once

#include <list>
#include <memory>

#include "server/render/cpu/packed_volume.h"
#include "server/render/plan/frame_plan.h"
#include "server/render/plan/grid_sights.h"

namespace mote::render {

/// What is drawn of a field; nothing is owned.
struct VisibleField {
    GridSight sight;
    const PackedVolume* volume = nullptr;  ///< of densities that are somewhere visible
};

class ResidentFields {
  public:
    /// One a field of the plan. Works in parallel. Throws storage::StorageError.
    std::vector<VisibleField> of(const FramePlan& plan);
    /// Gives up what belongs to data that nobody else holds any more.
    void dropExpired();

  private:
    struct Visible {
        Curve opacity;
        VisibleBlocks blocks;
    };
    struct Resident {
        std::weak_ptr<const storage::ParticleStep> step;
        const storage::ParticleStep* key;
        PackedVolume volume;
        BlockRanges ranges;
        std::list<Visible> visible;  ///< used last first
    };
    static constexpr std::size_t kept = 16;  ///< curves a volume: more than a picture has layers

    VisibleField density(const FieldPlan& field, const std::shared_ptr<const storage::ParticleStep>& step);
    Resident& resident(const std::shared_ptr<const storage::ParticleStep>& step);

    TransferTables tables_;
    std::list<Resident> volumes_;
    GridSights grids_;
};

}  // namespace mote::render
