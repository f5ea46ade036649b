// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/transfer_buffers.h"

#include <algorithm>

namespace mote::render {

const TransferBuffer& TransferBuffers::of(const ParticlesStyle& style) {
    Key key(style.volumeOpacity, style.colorMap);
    const auto found =
        std::find_if(entries_.begin(), entries_.end(), [&](const Entry& one) { return one.key == key; });
    if (found != entries_.end()) {
        entries_.splice(entries_.begin(), entries_, found);
        return entries_.front().made;
    }
    TransferBuffer made{TransferTable(style), {}};
    made.buffer = GlBuffer::of(std::span<const glm::vec4>(made.table.integrals()));
    entries_.push_front({std::move(key), std::move(made)});
    if (entries_.size() > kept) entries_.pop_back();
    return entries_.front().made;
}

}  // namespace mote::render
