// SPDX-License-Identifier: GPL-3.0-or-later
//
// PacketSights: what the rays of a packet see ahead in each field, kept so that all vectors of the packet's
// rays go by the same: the picture must not depend on how many rays a vector holds. Reused from packet to
// packet by the thread that owns it.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "server/render/cpu/packet.h"

namespace mote::render {

struct FieldSight {
    bool visible = false;  ///< by some ray, or by none
    bool fine = false;     ///< by some ray, in fine steps
    float until = -1.0F;   ///< slab up to which this holds
};

class PacketSights {
  public:
    void clear() {
        for (auto& sights : fields_) sights.clear();
    }
    /// The sight of that number in a field: walks of one packet ask for the same ones in the same order, the
    /// first that comes so far has it made by `look`.
    template <class Look>
    const FieldSight& of(std::size_t field, std::size_t number, const Look& look) {
        auto& sights = fields_[field];
        if (number == sights.size()) sights.push_back(look());
        return sights[number];
    }

  private:
    std::array<std::vector<FieldSight>, Packet::mostFields> fields_;
};

}  // namespace mote::render
