// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/session/outbox.h"

#include <algorithm>

#include "protocol/base/utf8.h"

namespace mote::server {

proto::ServerMessage failureMessage(std::uint64_t replyTo, const Error& error, bool fatal) {
    proto::ServerMessage message;
    message.set_reply_to(replyTo);
    auto& failure = *message.mutable_failure();
    failure.set_code(std::string(name(error.code)));
    failure.set_where(toUtf8(error.where));
    failure.set_message(toUtf8(error.message));
    failure.set_fatal(fatal);
    return message;
}

void Outbox::reply(Reply reply) {
    replyBytes_ += reply.bytes();
    replies_.push_back(std::move(reply));
}

void Outbox::jobChanged(std::shared_ptr<const proto::JobStatus> job) {
    if (allJobs_) return;
    const auto& id = job->id();
    jobs_.insert_or_assign(id, std::move(job));
    if (jobs_.size() > maxChangedJobs) allJobsChanged();
}

void Outbox::jobsTold(const proto::ServerMessage& reply) {
    jobs_.erase(reply.job().id());
    for (const auto& job : reply.jobs().jobs()) jobs_.erase(job.id());
}

void Outbox::allJobsChanged() {
    jobs_.clear();
    allJobs_ = true;
}

void Outbox::farewell(proto::ServerMessage message) {
    if (!farewell_) farewell_ = std::move(message);
}

template <class Condition>
void Outbox::drop(Condition condition, const Dropped& dropped) {
    std::erase_if(frames_, [&](const Waiting& waiting) {
        if (!condition(waiting)) return false;
        needsKey_ = needsKey_ || waiting.ofStream();
        dropped(waiting.begin > 0, waiting.ofStream());
        return true;
    });
}

/// A picture that is told by those before it is worth nothing without them.
void Outbox::frame(RenderedFrame frame, Clock::time_point now, const Dropped& dropped) {
    Waiting added{std::make_shared<const RenderedFrame>(std::move(frame)), now};
    if (orphan(added)) return dropped(false, true);
    if (added.ofStream()) {
        needsKey_ = false;
    } else if (added.replaceable()) {
        drop([](const Waiting& waiting) { return waiting.replaceable(); }, dropped);
    }
    frames_.push_back(std::move(added));
}

bool Outbox::orphan(const Waiting& waiting) const {
    return needsKey_ && waiting.ofStream() && !waiting.frame->message.key();
}

bool Outbox::anyReplaceable() const {
    return std::any_of(frames_.begin(), frames_.end(),
                       [](const Waiting& waiting) { return waiting.replaceable(); });
}

void Outbox::dropOutdated(const Dropped& dropped) {
    drop([](const Waiting& waiting) { return waiting.frame->canWait && !waiting.frame->wanted; }, dropped);
}

void Outbox::dropStale(Clock::time_point since, std::uint64_t latest, const Dropped& dropped) {
    drop(
        [&](const Waiting& waiting) {
            if (!waiting.replaceable()) return false;
            const bool stale = waiting.since < since && waiting.frame->message.view_id() != latest;
            if (stale || orphan(waiting)) return true;
            if (waiting.ofStream()) needsKey_ = false;
            return false;
        },
        dropped);
}

std::optional<Outbox::Item> Outbox::next(const Piece& piece) {
    using Kind = Item::Kind;
    if (farewell_) return Item{.kind = Kind::farewell, .message = *farewell_};
    if (!replies_.empty()) {
        replyBytes_ -= replies_.front().bytes();
        Reply reply = std::move(replies_.front());
        replies_.pop_front();
        return Item{.message = std::move(reply.message), .payload = std::move(reply.payload)};
    }
    if (viewFailure_) return Item{.message = *std::exchange(viewFailure_, std::nullopt)};
    if (std::exchange(allJobs_, false)) return Item{.kind = Kind::allJobs};
    if (!jobs_.empty())
        return Item{.kind = Kind::job, .job = std::move(jobs_.extract(jobs_.begin()).mapped())};
    if (std::exchange(followed_, false)) return Item{.kind = Kind::followed};
    if (std::exchange(catalogue_, false)) return Item{.kind = Kind::catalogue};
    return nextPiece(piece);
}

/// Frames keep their order: a newer one takes the place of an older one only where that is dropped.
std::optional<Outbox::Item> Outbox::nextPiece(const Piece& piece) {
    if (frames_.empty()) return std::nullopt;
    auto& [frame, since, begin] = frames_.front();
    const std::size_t left = frame->payload.size() - begin;
    const std::size_t size = piece(*frame, begin, left);
    if (size == 0 && left > 0) return std::nullopt;
    Item item{.kind = Item::Kind::frame, .frame = frame, .begin = begin, .size = size};
    begin += size;
    if (size == left) frames_.pop_front();
    return item;
}

}  // namespace mote::server
