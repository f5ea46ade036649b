// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/transfer_buffers.h"

#include <algorithm>

namespace mote::render {

template <class Make>
const TransferBuffer& TransferBuffers::of(Key key, const Make& make) {
    const auto found =
        std::find_if(entries_.begin(), entries_.end(), [&](const Entry& one) { return one.key == key; });
    if (found != entries_.end()) {
        entries_.splice(entries_.begin(), entries_, found);
        return entries_.front().made;
    }
    TransferBuffer made{make(), {}};
    made.buffer = GlBuffer::of(std::span<const glm::vec4>(made.table.integrals()));
    entries_.push_front({std::move(key), std::move(made)});
    if (entries_.size() > kept) entries_.pop_back();
    return entries_.front().made;
}

const TransferBuffer& TransferBuffers::of(const ParticlesStyle& style) {
    return of(std::pair(style.volumeOpacity, style.colorMap), [&] { return TransferTable(style); });
}

const TransferBuffer& TransferBuffers::of(const HybridTransfer& transfer) {
    return of(transfer, [&] {
        return TransferTable(
            transfer.span().low, transfer.span().high, [&](double v) { return transfer.extinction(v); },
            [&](double v) { return transfer.color(v); });
    });
}

}  // namespace mote::render
