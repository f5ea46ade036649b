// SPDX-License-Identifier: GPL-3.0-or-later
//
// A session that follows another, and what those may do who only follow.
#include "server/session/session.h"

namespace mote::server {

/// What a follower is answered; the rest is not for them.
Status Session::allowed(const proto::ClientMessage& message) const {
    using Body = proto::ClientMessage;
    if (role_ == Role::owner) return success();
    switch (message.body_case()) {
        case Body::kHello:
        case Body::kSetView:
        case Body::kCredit:
        case Body::kListDatasets:
        case Body::kDescribe:
        case Body::kQuery:
        case Body::kCancelQuery:
        case Body::kListSessions:
        case Body::kFollow:
        case Body::kPing:
        case Body::kPong:
        case Body::BODY_NOT_SET:
            return success();
        default:
            return Error{ErrorCode::permissionDenied, "message",
                         "a follower may look at datasets and follow sessions, and nothing else"};
    }
}

void Session::listSessions(std::uint64_t request) {
    proto::ServerMessage message;
    *message.mutable_sessions() = context_.following->list(id_);
    reply(request, std::move(message));
}

void Session::follow(std::uint64_t request, SessionId whom) {
    const auto before = std::exchange(followRequest_, request);
    const auto show = [weak = weak_from_this()](const proto::Followed& followed) {
        if (const auto self = weak.lock()) self->show(followed);
    };
    followReply_ = request;
    const auto follows = context_.following->follow(id_, whom, show);
    if (follows.ok()) return;
    followRequest_ = before;
    followReply_ = 0;
    reply(request, failureMessage(request, follows.error(), false));
}

/// Who hears of it, and the pictures, which come after.
void Session::show(const proto::Followed& followed) {
    if (closed_ || leaving_) return;
    followed_ = followed;
    outbox_.followedChanged();
    writerWake_.notify();
    if (followed.has_view()) drawFollowed(followed.view());
}

}  // namespace mote::server
