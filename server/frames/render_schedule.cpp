// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/frames/render_schedule.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "protocol/base/mote_check.h"
#include "protocol/wire/framing.h"

namespace mote::server {

void RenderSchedule::open(SessionId session, std::uint32_t credits, bool background) {
    Client& client = clients_[session];
    client.credits = credits;
    client.background = background;
}

void RenderSchedule::close(SessionId session) {
    clients_.erase(session);
    reconsider();
}

Status RenderSchedule::setView(SessionId session, std::shared_ptr<const ViewTask> task) {
    const auto found = clients_.find(session);
    if (found == clients_.end()) return success();
    Client& client = found->second;
    if (task->queued && client.stage != Stage::done) {
        if (client.queue.size() + 1 >= wire::maxQueuedViews) {
            return Error{ErrorCode::resourceExhausted, "queued",
                         fmt::format("{} views wait to be drawn already: ask again when one is answered",
                                     wire::maxQueuedViews)};
        }
        client.queue.push_back(std::move(task));
        return success();
    }
    client.queue.clear();
    begin(client, std::move(task));
    reconsider();
    return success();
}

void RenderSchedule::addCredits(SessionId session, std::uint32_t count) {
    const auto found = clients_.find(session);
    if (found == clients_.end()) return;
    found->second.credits += count;
    reconsider();
}

void RenderSchedule::begin(Client& client, std::shared_ptr<const ViewTask> task) {
    client.used = std::max(client.used, usedLeast_);
    client.task = std::move(task);
    enter(client, client.task->finalOnly ? Stage::exact : Stage::quick);
}

/// A stage's due time: at once for what the client waits for, at rest for a refinement, never while it moves.
/// A view that is done with gives way to the next one that is queued.
void RenderSchedule::enter(Client& client, Stage stage) {
    const bool refinement = stage != Stage::quick && !client.task->finalOnly;
    client.waits = false;
    client.stage = refinement && client.task->moving ? Stage::done : stage;
    client.due = client.task->arrived + (refinement ? settings_.restDelay : Clock::duration::zero());
    client.due = std::max(client.due, client.task->notBefore);
    if (client.stage != Stage::done || client.queue.empty()) return;
    auto next = std::move(client.queue.front());
    client.queue.pop_front();
    begin(client, std::move(next));
    // How long it stood in its own client's queue is nobody else's concern.
    client.fresh = true;
}

bool RenderSchedule::urgent(const Client& client, Clock::time_point now) const {
    if (client.background) return false;
    return client.stage == Stage::quick || now - client.due > settings_.patience;
}

bool RenderSchedule::foregroundOpen() const {
    return std::any_of(clients_.begin(), clients_.end(),
                       [](const auto& entry) { return !entry.second.background && entry.second.open(); });
}

Clock::time_point RenderSchedule::backgroundDue() const {
    auto due = quietSince_ + settings_.backgroundDelay;
    for (const auto& [session, client] : clients_) {
        const bool moves = !client.background && client.task != nullptr && client.task->moving;
        if (moves) due = std::max(due, client.task->arrived + settings_.handDelay);
    }
    return due;
}

/// Urgent ones first, and among equals the one that used least, then the one that was served longest ago;
/// null: nothing is due.
RenderSchedule::Clients::value_type* RenderSchedule::choose(Clock::time_point now, bool background) {
    Clients::value_type* best = nullptr;
    const auto better = [&](const Client& a, const Client& b) {
        const bool urgentA = urgent(a, now), urgentB = urgent(b, now);
        if (urgentA != urgentB) return urgentA;
        return std::tie(a.used, a.served) < std::tie(b.used, b.served);
    };
    for (auto& entry : clients_) {
        const Client& client = entry.second;
        if (client.background != background || !client.open() || client.due > now) continue;
        if (!best || better(client, best->second)) best = &entry;
    }
    return best;
}

/// Whether it was a matter of time alone that `chosen` goes before it. Others save nothing up.
bool RenderSchedule::contends(const Client& client, const Client& chosen, Clock::time_point now) const {
    return client.background == chosen.background && client.open() && client.due <= now &&
           (urgent(client, now) || !urgent(chosen, now));
}

std::optional<RenderJob> RenderSchedule::next(Clock::time_point now) {
    MOTE_CHECK(!running_);
    now_ = now;
    for (auto& [session, client] : clients_) {
        if (std::exchange(client.fresh, false)) client.due = std::max(client.due, now);
        if (client.waits && client.until && *client.until <= now) client.waits = false;
    }
    const bool foreground = foregroundOpen();
    if (!foreground && std::exchange(busy_, false)) quietSince_ = now;
    if (!foreground && now < backgroundDue()) return std::nullopt;
    auto* const best = choose(now, !foreground);
    if (!best) return std::nullopt;
    Client& client = best->second;
    --client.credits;
    client.served = ++turn_;
    busy_ = foreground;
    usedLeast_ = std::max(usedLeast_, client.used);
    for (auto& [session, other] : clients_) {
        if (!contends(other, client, now)) other.used = std::max(other.used, usedLeast_);
    }
    const bool patient = client.stage == Stage::quick || urgent(client, now);
    running_ = Running{best->first, client.task, client.stage, client.background, patient, {}, {}};
    RenderJob job{best->first, client.task, client.stage, running_->stop.get_token(),
                  running_->pause.get_token()};
    // Who waits already has it give way as soon as it can.
    reconsider();
    return job;
}

std::optional<Clock::time_point> RenderSchedule::nextDue() const {
    const bool background = !foregroundOpen();
    std::optional<Clock::time_point> due;
    for (const auto& [session, client] : clients_) {
        if (client.background != background || !client.open()) continue;
        due = due ? std::min(*due, client.due) : client.due;
    }
    if (due && background) due = std::max(*due, backgroundDue());
    for (const auto& [session, client] : clients_) {
        if (client.waits && client.until) due = due ? std::min(*due, *client.until) : client.until;
    }
    return due;
}

bool RenderSchedule::current(const RenderJob& job) const {
    const auto found = clients_.find(job.session);
    return found != clients_.end() && found->second.task == job.task;
}

void RenderSchedule::finish(const RenderJob& job, bool returnCredit, std::optional<Stage> stage) {
    MOTE_CHECK(running_ && running_->session == job.session);
    running_.reset();
    const auto found = clients_.find(job.session);
    if (found == clients_.end()) return;
    Client& client = found->second;
    if (returnCredit) ++client.credits;
    if (stage && client.task == job.task) enter(client, *stage);
}

void RenderSchedule::charge(const RenderJob& job, Clock::duration took) {
    const auto found = clients_.find(job.session);
    if (found != clients_.end()) found->second.used += took;
}

void RenderSchedule::finishDrawn(const RenderJob& job, Stage next) {
    finish(job, false, next);
}

void RenderSchedule::finishStopped(const RenderJob& job) {
    finish(job, true, std::nullopt);
}

void RenderSchedule::finishWaiting(const RenderJob& job, std::optional<Clock::time_point> until) {
    finish(job, true, std::nullopt);
    const auto found = clients_.find(job.session);
    if (found == clients_.end() || found->second.task != job.task) return;
    found->second.waits = true;
    found->second.until = until;
}

void RenderSchedule::dataArrived(Clock::time_point now) {
    now_ = now;
    for (auto& [session, client] : clients_) {
        if (std::exchange(client.waits, false)) client.due = now;
    }
    reconsider();
}

void RenderSchedule::finishFailed(const RenderJob& job) {
    finish(job, true, Stage::done);
}

/// A background picture is lost to whatever others want drawn, a refinement that has not waited long to quick
/// pictures.
bool RenderSchedule::stopsRunning(const Client& client) const {
    if (client.background || !client.open()) return false;
    if (running_->background) return true;
    // A view is due when it arrives, but for one that others go before.
    const bool due = client.due <= std::max(now_, client.task->arrived);
    return !running_->patient && client.stage == Stage::quick && due;
}

/// A refinement takes turns with whatever others want drawn, now or soon.
bool RenderSchedule::pausesRunning(const Clients::value_type& entry) const {
    const auto& [session, client] = entry;
    return running_->stage != Stage::quick && session != running_->session && !client.background &&
           client.open();
}

void RenderSchedule::stopRunning() {
    running_->stop.request_stop();
    running_->pause.request_stop();
}

void RenderSchedule::reconsider() {
    if (!running_) return;
    const auto found = clients_.find(running_->session);
    const bool gone = found == clients_.end();
    const bool outdated = !gone && found->second.task != running_->task && running_->stage != Stage::quick;
    const auto any = [this](auto condition) {
        return std::any_of(clients_.begin(), clients_.end(), condition);
    };
    const bool overtaken = any([this](const auto& entry) { return stopsRunning(entry.second); });
    if (gone || outdated || overtaken) return stopRunning();
    if (any([this](const auto& entry) { return pausesRunning(entry); })) running_->pause.request_stop();
}

}  // namespace mote::server
