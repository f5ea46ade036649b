// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/resident_volumes.h"

#include "server/render/plan/latest.h"

namespace mote::render {
VisibleVolume ResidentVolumes::of(const std::shared_ptr<const storage::ParticleStep>& step,
                                  const ParticlesStyle& style) {
    if (!(style.volumeOpacity.maximum() > 0.0)) return {};
    Resident& kin = resident(step);
    const VolumeTable& transfer = table(style);
    const Visible& visible = latest(
        kin.visible, kept, [&](const Visible& one) { return one.volumeOpacity == style.volumeOpacity; },
        [&] {
            return Visible{style.volumeOpacity, VisibleBlocks(kin.ranges, transfer)};
        });
    if (!visible.blocks.any()) return {};
    return {&kin.volume, &transfer, &visible.blocks};
}

void ResidentVolumes::dropExpired() {
    volumes_.remove_if([](const Resident& one) { return one.step.expired(); });
}

const VolumeTable& ResidentVolumes::table(const ParticlesStyle& style) {
    return latest(
               tables_, kept,
               [&](const Table& one) {
                   return one.volumeOpacity == style.volumeOpacity && one.colorMap == style.colorMap;
               },
               [&] {
                   return Table{style.volumeOpacity, style.colorMap, VolumeTable(style)};
               })
        .table;
}

ResidentVolumes::Resident& ResidentVolumes::resident(
    const std::shared_ptr<const storage::ParticleStep>& step) {
    // A new step may stand at the address of one that is gone: the weak pointers tell them apart.
    for (auto& one : volumes_) {
        if (one.key == step.get() && !one.step.expired()) return one;
    }
    PackedVolume volume(*step);
    BlockRanges ranges(volume);
    return volumes_.emplace_back(Resident{step, step.get(), std::move(volume), std::move(ranges), {}});
}

}  // namespace mote::render
