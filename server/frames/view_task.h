// SPDX-License-Identifier: GPL-3.0-or-later
//
// A ViewTask is a view that a client wants to see, as the renderer knows it. An immutable value, shared
// between the session that parsed it and the thread that renders it; which of two is newer is told by
// identity.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "protocol/scene/page.h"
#include "protocol/scene/view.h"
#include "server/render/plan/picture.h"

namespace mote::server {

using Clock = std::chrono::steady_clock;
using SessionId = std::uint64_t;

inline double milliseconds(Clock::duration duration) {
    return std::chrono::duration<double, std::milli>(duration).count();
}

struct ViewTask {
    View view;
    std::uint64_t viewId = 0;
    std::uint64_t request = 0;  ///< the client's number of the message, for a failure
    bool finalOnly = false;     ///< only the exact picture
    bool queued = false;        ///< drawn after those before it, which stay; only with finalOnly
    bool moving = false;        ///< the hand is still on it: no refinement
    render::PixelFormat format = render::PixelFormat::srgb8;  ///< of the exact picture
    std::optional<Page> page;                                 ///< the exact picture as a document
    std::int64_t askedNs = 0;                                 ///< the client's clock
    Clock::time_point arrived;
    Clock::time_point notBefore;  ///< others go first: it ended a server before
    std::string bytes;            ///< of the view's message: whose fault a crash is
};

}  // namespace mote::server
