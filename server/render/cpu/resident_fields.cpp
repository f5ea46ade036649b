// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/resident_fields.h"

#include "protocol/scene/most_recent.h"

namespace mote::render {

std::vector<VisibleField> ResidentFields::of(const FramePlan& plan) {
    std::vector<VisibleField> visible;
    for (const auto& field : plan.fields) {
        if (const auto* const cells = field.density()) {
            visible.push_back(density(field, cells->step));
        } else {
            visible.push_back({.sight = grids_.of(field, *field.grid())});
        }
    }
    return visible;
}

VisibleField ResidentFields::density(const FieldPlan& field,
                                     const std::shared_ptr<const storage::ParticleStep>& step) {
    Resident& kin = resident(step);
    const TransferTable& table = tables_.of(field.transfer);
    const Visible& visible = mostRecent(
        kin.visible, kept, [&](const Visible& one) { return one.opacity == field.transfer.opacity; },
        [&] {
            return Visible{field.transfer.opacity, VisibleBlocks(kin.ranges, table)};
        });
    if (!visible.blocks.any()) return {};
    return {{&table, &visible.blocks, &kin.ranges}, &kin.volume};
}

void ResidentFields::dropExpired() {
    volumes_.remove_if([](const Resident& one) { return one.step.expired(); });
    grids_.dropExpired();
}

ResidentFields::Resident& ResidentFields::resident(const std::shared_ptr<const storage::ParticleStep>& step) {
    // A new step may stand at the address of one that is gone: the weak pointers tell them apart.
    for (auto& one : volumes_) {
        if (one.key == step.get() && !one.step.expired()) return one;
    }
    PackedVolume volume(*step);
    BlockRanges ranges = volume.ranges();
    return volumes_.emplace_back(Resident{step, step.get(), std::move(volume), std::move(ranges), {}});
}

}  // namespace mote::render
