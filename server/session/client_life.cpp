// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/session/client_life.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "protocol/wire/framing.h"

namespace mote::server {
namespace {

/// "30 s", "12 h": for people.
std::string durationText(ClientLife::Milliseconds duration) {
    using namespace std::chrono_literals;
    if (duration >= 1h) return fmt::format("{} h", duration / 1h);
    if (duration >= 1s) return fmt::format("{} s", duration / 1s);
    return fmt::format("{} ms", duration.count());
}

}  // namespace

ClientLife::ClientLife(const proto::Hello& hello, Milliseconds silence, Milliseconds idle,
                       Clock::time_point now)
    : limit_(silence),
      idle_(hello.background() ? Milliseconds(0) : idle),
      silence_(hello.minor() >= wire::pingsFromMinor ? silence : Milliseconds(0), now),
      lastWish_(now) {}

ClientLife::Milliseconds ClientLife::interval() const {
    const auto silent = silence_.interval();
    if (idle_.count() == 0) return silent;
    const auto idle = std::clamp<Milliseconds>(idle_ / 8, Milliseconds(1), std::chrono::minutes(1));
    return silent.count() == 0 ? idle : std::min(silent, idle);
}

ClientLife::Finding ClientLife::at(Clock::time_point now, std::uint64_t progress) {
    const auto verdict = silence_.at(now, progress);
    if (verdict == wire::Silence::Verdict::gone) {
        return {false, Error{ErrorCode::cancelled, "silence",
                             fmt::format("nothing was heard of the client for {}", durationText(limit_))}};
    }
    if (idle_.count() > 0 && now - lastWish_ >= idle_) {
        return {false, Error{ErrorCode::cancelled, "session",
                             fmt::format("it was idle for {}; connect again to go on", durationText(idle_))}};
    }
    return {verdict == wire::Silence::Verdict::ask};
}

void ClientLife::heard(const proto::ClientMessage& message, Clock::time_point now) {
    if (!message.has_ping() && !message.has_pong() && !message.has_credit()) lastWish_ = now;
}

void ClientLife::told(const proto::ServerMessage& message, Clock::time_point now) {
    if (message.has_frame() || message.has_job() || message.has_jobs()) lastWish_ = now;
}

}  // namespace mote::server
