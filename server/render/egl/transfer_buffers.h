// SPDX-License-Identifier: GPL-3.0-or-later
//
// TransferBuffers: transfer tables in the device's memory, kept as long as their curves are in use. Owned by
// the device; used while its context is current.
#pragma once

#include <cstdint>
#include <list>
#include <utility>

#include "server/render/egl/gl_objects.h"
#include "server/render/transfer_table.h"

namespace mote::render {

struct TransferBuffer {
    TransferTable table;
    GlBuffer buffer;
};

class TransferBuffers {
  public:
    /// The table of a style's volume curve and colour map. The reference stays valid for the next 15 calls.
    const TransferBuffer& of(const ParticlesStyle& style);

  private:
    using Key = std::pair<Curve, ColorMap>;
    struct Entry {
        Key key;
        TransferBuffer made;
    };

    static constexpr std::size_t kept = 16;
    std::list<Entry> entries_;  ///< last used first
};

}  // namespace mote::render
