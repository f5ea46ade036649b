// SPDX-License-Identifier: GPL-3.0-or-later
//
// Whether a session's client is still there, and still wants something.
#include <fmt/format.h>

#include <algorithm>

#include "server/session/session.h"

namespace mote::server {
namespace {

using Milliseconds = std::chrono::milliseconds;

/// How often a session is looked at that may be idle for so long; 0: never.
Milliseconds lookFor(Milliseconds idle) {
    return idle.count() == 0 ? idle
                             : std::clamp<Milliseconds>(idle / 8, Milliseconds(1), std::chrono::minutes(1));
}

/// "30 s", "12 h": for people.
std::string durationText(Milliseconds duration) {
    using namespace std::chrono_literals;
    if (duration >= 1h) return fmt::format("{} h", duration / 1h);
    if (duration >= 1s) return fmt::format("{} s", duration / 1s);
    return fmt::format("{} ms", duration.count());
}

}  // namespace

/// An older client does not know our pings, and one in the background waits as long as others work.
void Session::beginLife(const proto::Hello& hello) {
    const auto now = Clock::now();
    lastWish_ = now;
    if (hello.minor() >= wire::pingsFromMinor) silence_ = wire::Silence(context_.silence, now);
    idle_ = hello.background() ? Milliseconds(0) : context_.idle;
    lookLater();
}

void Session::lookLater() {
    const auto silence = silence_.interval(), idle = lookFor(idle_);
    const auto wait =
        silence.count() == 0 || idle.count() == 0 ? std::max(silence, idle) : std::min(silence, idle);
    if (wait.count() == 0) return;
    life_.expires_after(wait);
    life_.async_wait([weak = weak_from_this()](const asio::error_code& code) {
        const auto self = weak.lock();
        if (!code && self && !self->closed_ && !self->leaving_) self->orClose([&] { self->look(); });
    });
}

void Session::look() {
    const auto now = Clock::now();
    const auto verdict = silence_.at(now, stream_.progress());
    if (verdict == wire::Silence::Verdict::gone) {
        return leave({ErrorCode::cancelled, "silence",
                      fmt::format("nothing was heard of the client for {}", durationText(context_.silence))});
    }
    if (idle_.count() > 0 && now - lastWish_ >= idle_) {
        return leave({ErrorCode::cancelled, "session",
                      fmt::format("it was idle for {}; connect again to go on", durationText(idle_))});
    }
    if (verdict == wire::Silence::Verdict::ask) {
        proto::ServerMessage ping;
        ping.mutable_ping();
        reply(0, std::move(ping));
    }
    lookLater();
}

/// Pings and what returns by itself are no wishes.
void Session::noteWish(const proto::ClientMessage& message) {
    if (!message.has_ping() && !message.has_pong() && !message.has_credit()) lastWish_ = Clock::now();
}

/// Who is told what they wait for is not idle: the pictures of a film, the end of a job.
void Session::noteNews(const proto::ServerMessage& message) {
    if (message.has_frame() || message.has_job() || message.has_jobs()) lastWish_ = Clock::now();
}

}  // namespace mote::server
