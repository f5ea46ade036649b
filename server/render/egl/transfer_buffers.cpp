// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/transfer_buffers.h"

#include <algorithm>

namespace mote::render {

const TransferBuffer& TransferBuffers::of(const ParticlesStyle& style) {
    const auto found = std::find_if(buffers_.begin(), buffers_.end(), [&](const TransferBuffer& one) {
        return one.volumeOpacity == style.volumeOpacity && one.colorMap == style.colorMap;
    });
    if (found != buffers_.end()) {
        buffers_.splice(buffers_.begin(), buffers_, found);
        return buffers_.front();
    }
    TransferBuffer made{style.volumeOpacity, style.colorMap, TransferTable(style), {}};
    made.buffer = GlBuffer::of(std::span<const glm::vec4>(made.table.integrals()));
    buffers_.push_front(std::move(made));
    if (buffers_.size() > kept) buffers_.pop_back();
    return buffers_.front();
}

}  // namespace mote::render
