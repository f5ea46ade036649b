// SPDX-License-Identifier: GPL-3.0-or-later
//
// PacketSights: what the rays of a packet see ahead in each volume, kept so that all vectors of the packet's
// rays go by the same: the picture must not depend on how many rays a vector holds. Reused from packet to
// packet by the thread that owns it.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "server/render/cpu/packet.h"

namespace mote::render {

struct VolumeSight {
    bool visible = false;  ///< by some ray, or by none
    bool fine = false;     ///< by some ray, in fine steps
    float until = -1.0F;   ///< slab up to which this holds
};

class PacketSights {
  public:
    void clear() {
        for (auto& sights : volumes_) sights.clear();
    }
    /// The sight of that number in a volume: walks of one packet ask for the same ones in the same order, the
    /// first that comes so far has it made by `look`.
    template <class Look>
    const VolumeSight& of(std::size_t volume, std::size_t number, const Look& look) {
        auto& sights = volumes_[volume];
        if (number == sights.size()) sights.push_back(look());
        return sights[number];
    }

  private:
    std::array<std::vector<VolumeSight>, Packet::mostLayers> volumes_;
};

}  // namespace mote::render
