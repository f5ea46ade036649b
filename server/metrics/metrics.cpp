// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/metrics/metrics.h"

namespace mote::server {

void Metrics::countSent(const proto::ServerMessage& message, std::size_t payload) {
    bytesSent.add(message.ByteSizeLong() + payload);
    if (message.has_failure()) {
        for (std::size_t code = 0; code < errorCodes; ++code) {
            if (name(static_cast<ErrorCode>(code)) == message.failure().code()) errors[code].add();
        }
    }
    // Of later pieces of a frame only the sequence is said again.
    if (!message.has_frame() || message.frame().payload_begin() > 0) return;
    const auto& frame = message.frame();
    (frame.final() ? framesFinal : framesMoving).add();
    queued.add(frame.queued_ms());
    plan.add(frame.plan_ms());
    render.add(frame.render_ms());
    encode.add(frame.encode_ms());
    total.add(frame.total_ms());
}

}  // namespace mote::server
