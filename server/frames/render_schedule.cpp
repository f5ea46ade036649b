// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/frames/render_schedule.h"

#include <algorithm>
#include <utility>

#include "protocol/scene/mote_check.h"

namespace mote::server {

void RenderSchedule::open(SessionId session, std::uint32_t credits) {
    clients_[session].credits = credits;
}

void RenderSchedule::close(SessionId session) {
    clients_.erase(session);
    reconsider();
}

void RenderSchedule::setView(SessionId session, std::shared_ptr<const ViewTask> task) {
    const auto found = clients_.find(session);
    if (found == clients_.end()) return;
    Client& client = found->second;
    client.task = std::move(task);
    enter(client, client.task->finalOnly ? Stage::exact : Stage::quick);
    reconsider();
}

void RenderSchedule::addCredits(SessionId session, std::uint32_t count) {
    const auto found = clients_.find(session);
    if (found == clients_.end()) return;
    found->second.credits += count;
    reconsider();
}

/// A stage's due time: at once for what the client waits for, at rest for a refinement, never while it moves.
void RenderSchedule::enter(Client& client, Stage stage) {
    const bool refinement = stage != Stage::quick && !client.task->finalOnly;
    client.waits = false;
    client.stage = refinement && client.task->moving ? Stage::done : stage;
    client.due = client.task->arrived + (refinement ? settings_.restDelay : Clock::duration::zero());
    client.due = std::max(client.due, client.task->notBefore);
}

bool RenderSchedule::urgent(const Client& client, Clock::time_point now) const {
    return client.stage == Stage::quick || now - client.due > settings_.patience;
}

std::optional<RenderJob> RenderSchedule::next(Clock::time_point now) {
    MOTE_CHECK(!running_);
    std::pair<const SessionId, Client>* best = nullptr;
    // Urgent ones first, and among equals the one that was served longest ago.
    const auto better = [&](const Client& a, const Client& b) {
        const bool urgentA = urgent(a, now), urgentB = urgent(b, now);
        return urgentA != urgentB ? urgentA : a.served < b.served;
    };
    for (auto& entry : clients_) {
        const Client& client = entry.second;
        if (!client.open() || client.due > now) continue;
        if (!best || better(client, best->second)) best = &entry;
    }
    if (!best) return std::nullopt;
    Client& client = best->second;
    --client.credits;
    client.served = ++turn_;
    const bool preemptible = client.stage != Stage::quick && !urgent(client, now);
    running_ = Running{best->first, client.task, client.stage, preemptible, {}};
    return RenderJob{best->first, client.task, client.stage, running_->stop.get_token()};
}

std::optional<Clock::time_point> RenderSchedule::nextDue() const {
    std::optional<Clock::time_point> due;
    for (const auto& [session, client] : clients_) {
        if (!client.open()) continue;
        due = due ? std::min(*due, client.due) : client.due;
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

void RenderSchedule::finishDrawn(const RenderJob& job, Stage next) {
    finish(job, false, next);
}

void RenderSchedule::finishStopped(const RenderJob& job) {
    finish(job, true, std::nullopt);
}

void RenderSchedule::finishWaiting(const RenderJob& job) {
    finish(job, true, std::nullopt);
    const auto found = clients_.find(job.session);
    if (found != clients_.end() && found->second.task == job.task) found->second.waits = true;
}

void RenderSchedule::dataArrived(Clock::time_point now) {
    for (auto& [session, client] : clients_) {
        if (std::exchange(client.waits, false)) client.due = now;
    }
}

void RenderSchedule::finishFailed(const RenderJob& job) {
    finish(job, true, Stage::done);
}

void RenderSchedule::reconsider() {
    if (!running_) return;
    const auto found = clients_.find(running_->session);
    const bool gone = found == clients_.end();
    const bool outdated = !gone && found->second.task != running_->task && running_->stage != Stage::quick;
    const bool overtaken =
        running_->preemptible && std::any_of(clients_.begin(), clients_.end(), [](const auto& entry) {
            return entry.second.stage == Stage::quick && entry.second.credits > 0;
        });
    if (gone || outdated || overtaken) running_->stop.request_stop();
}

}  // namespace mote::server
