// SPDX-License-Identifier: GPL-3.0-or-later
//
// ResidentVolumes: what the device keeps of steps and of styles to draw volumes: packed volumes, transfer
// tables, and where a volume is visible. It holds no step alive. Owned by the device, used on its thread;
// what it returns may be read by any number until the next picture.
#pragma once

#include <list>
#include <memory>

#include "server/render/cpu/composite_frame.h"

namespace mote::render {

class ResidentVolumes {
  public:
    /// Nothing where the style shows nothing of the volume. Works in parallel. Throws storage::StorageError.
    VisibleVolume of(const std::shared_ptr<const storage::ParticleStep>& step, const ParticlesStyle& style);
    /// Gives up the volumes of steps that nobody else holds any more.
    void dropExpired();

  private:
    struct Table {
        Curve volumeOpacity;
        ColorMap colorMap;
        VolumeTable table;
    };
    struct Visible {
        Curve volumeOpacity;
        VisibleBlocks blocks;
    };
    struct Resident {
        std::weak_ptr<const storage::ParticleStep> step;
        const storage::ParticleStep* key;
        PackedVolume volume;
        BlockRanges ranges;
        std::list<Visible> visible;  ///< used last first
    };
    static constexpr std::size_t kept = 16;  ///< tables, and curves a volume: more than a picture has layers

    const VolumeTable& table(const ParticlesStyle& style);
    Resident& resident(const std::shared_ptr<const storage::ParticleStep>& step);

    std::list<Table> tables_;  ///< used last first
    std::list<Resident> volumes_;
};

}  // namespace mote::render
