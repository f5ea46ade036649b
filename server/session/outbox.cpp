// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/session/outbox.h"

#include "server/session/utf8.h"

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

void Outbox::jobChanged(const std::string& id) {
    if (allJobs_) return;
    jobs_.insert(id);
    if (jobs_.size() <= maxChangedJobs) return;
    jobs_.clear();
    allJobs_ = true;
}

void Outbox::farewell(proto::ServerMessage message) {
    if (!farewell_) farewell_ = std::move(message);
}

std::optional<Outbox::Item> Outbox::next() {
    using Kind = Item::Kind;
    if (farewell_) return Item{Kind::farewell, *farewell_, {}, {}};
    if (!replies_.empty()) {
        Item item{Kind::message, std::move(replies_.front()), {}, {}};
        replies_.pop_front();
        return item;
    }
    if (viewFailure_) {
        Item item{Kind::message, *std::move(viewFailure_), {}, {}};
        viewFailure_.reset();
        return item;
    }
    if (std::exchange(allJobs_, false)) return Item{Kind::allJobs, {}, {}, {}};
    if (!jobs_.empty()) return Item{Kind::job, {}, std::move(jobs_.extract(jobs_.begin()).value()), {}};
    if (std::exchange(catalogue_, false)) return Item{Kind::catalogue, {}, {}, {}};
    if (frames_.empty()) return std::nullopt;
    Item item{Kind::frame, {}, {}, std::move(frames_.front())};
    frames_.pop_front();
    return item;
}

}  // namespace mote::server
