// SPDX-License-Identifier: GPL-3.0-or-later
//
// TransferBuffers: transfer tables in the device's memory, kept as long as their curves are in use. Owned by
// the device; used while its context is current.
#pragma once

#include <cstdint>
#include <list>

#include "server/render/egl/gl_objects.h"
#include "server/render/transfer_table.h"

namespace mote::render {

struct TransferBuffer {
    Curve volumeOpacity;
    ColorMap colorMap;
    TransferTable table;
    GlBuffer buffer;
};

class TransferBuffers {
  public:
    /// The table of a style's volume curve and colour map. The reference stays valid for the next 15 calls.
    const TransferBuffer& of(const ParticlesStyle& style);

  private:
    static constexpr std::size_t kept = 16;
    std::list<TransferBuffer> buffers_;  ///< last used first
};

}  // namespace mote::render
