// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/session/following.h"

#include <utility>

namespace mote::server {
namespace {

/// What others are shown of a view: on the way to the exact picture, whatever it was asked for as.
proto::SetView plain(const proto::SetView& view) {
    proto::SetView shown;
    *shown.mutable_view() = view.view();
    shown.set_view_id(view.view_id());
    shown.set_moving(view.moving());
    return shown;
}

}  // namespace

void Following::enter(SessionId session, std::string client) {
    shown_.emplace(session, Shown{std::move(client)});
}

void Following::leave(SessionId session) {
    shown_.erase(session);
    unfollow(session);
    if (latest_ == session) latest_ = 0;
}

void Following::goOn(SessionId before, SessionId now) {
    for (auto& [id, follower] : followers_) {
        if (follower.whom == before && before != 0) follower.whom = now;
    }
}

void Following::viewChanged(SessionId session, const proto::SetView& view) {
    const auto found = shown_.find(session);
    if (found == shown_.end()) return;
    found->second.view = plain(view);
    latest_ = session;
    const auto message = toMessage(session);
    for (const auto& [id, follower] : followers_) {
        if (id != session && (follower.whom == session || follower.whom == 0)) follower.show(message);
    }
}

proto::Sessions Following::list(SessionId asker) const {
    proto::Sessions sessions;
    for (const auto& [id, shown] : shown_) {
        if (id == asker) continue;
        auto& entry = *sessions.add_sessions();
        entry.set_session(id);
        entry.set_client(shown.client);
        entry.set_has_view(shown.view.has_value());
    }
    return sessions;
}

Status Following::follow(SessionId follower, SessionId whom, Show show) {
    if (whom == follower || (whom != 0 && !shown_.contains(whom)))
        return Error{ErrorCode::notFound, "session", "no other session of this number is there"};
    const SessionId now = whom == 0 && latest_ != follower ? latest_ : whom;
    const auto [entry, isNew] = followers_.insert_or_assign(follower, Follower{whom, std::move(show)});
    entry->second.show(toMessage(now));
    return success();
}

proto::Followed Following::toMessage(SessionId session) const {
    proto::Followed message;
    const auto found = shown_.find(session);
    if (found == shown_.end()) return message;
    message.set_session(session);
    message.set_client(found->second.client);
    if (found->second.view) *message.mutable_view() = *found->second.view;
    return message;
}

}  // namespace mote::server
