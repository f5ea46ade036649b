// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/session/role.h"

namespace mote::server {

Status allowed(Role role, const proto::ClientMessage& message) {
    using Body = proto::ClientMessage;
    if (role == Role::owner) return success();
    switch (message.body_case()) {
        case Body::kHello:
        case Body::kSetView:
        case Body::kCredit:
        case Body::kListDatasets:
        case Body::kDescribe:
        case Body::kGetThumbnail:
        case Body::kListLoaded:
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

}  // namespace mote::server
