// SPDX-License-Identifier: GPL-3.0-or-later
//
// TransferBuffers: transfer tables in the device's memory, kept as long as their curves are in use. Owned by
// the device; used while its context is current.
#pragma once

#include <cstdint>
#include <list>
#include <utility>
#include <variant>

#include "server/render/egl/gl_objects.h"
#include "server/render/hybrid/hybrid_transfer.h"
#include "server/render/transfer_table.h"

namespace mote::render {

struct TransferBuffer {
    TransferTable table;
    GlBuffer buffer;
};

class TransferBuffers {
  public:
    /// The table of a style's volume curve and colour map, or of a hybrid volume's functions. The reference
    /// stays valid for the next 15 calls.
    const TransferBuffer& of(const ParticlesStyle& style);
    const TransferBuffer& of(const HybridTransfer& transfer);

  private:
    using Key = std::variant<std::pair<Curve, ColorMap>, HybridTransfer>;
    struct Entry {
        Key key;
        TransferBuffer made;
    };
    template <class Make>
    const TransferBuffer& of(Key key, const Make& make);

    static constexpr std::size_t kept = 16;
    std::list<Entry> entries_;  ///< last used first
};

}  // namespace mote::render
