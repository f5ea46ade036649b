// SPDX-License-Identifier: GPL-3.0-or-later
//
// Following: whose view can be followed, and who follows whom. It knows sessions by their numbers alone.
// Owned by the server; one thread.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "server/frames/view_task.h"

namespace mote::server {

class Following {
  public:
    using Show = std::function<void(const proto::Followed&)>;

    /// A session whose view can be followed; `client`: as it calls itself, UTF-8.
    void enter(SessionId session, std::string client);
    /// It is there no more, nor does it follow. Who followed it keeps the last view.
    void leave(SessionId session);
    /// A session has come back under another number: so have those who follow it.
    void goOn(SessionId before, SessionId now);
    void viewChanged(SessionId session, const proto::SetView& view);

    /// All that the asker can follow.
    proto::Sessions list(SessionId asker) const;
    /// `show` is called now and at each change; 0: whoever changed their view last. Errors: notFound.
    Status follow(SessionId follower, SessionId whom, Show show);
    void unfollow(SessionId follower) { followers_.erase(follower); }

  private:
    struct Shown {
        std::string client;
        std::optional<proto::SetView> view = {};
    };
    struct Follower {
        SessionId whom;
        Show show;
    };
    proto::Followed toMessage(SessionId session) const;

    std::map<SessionId, Shown> shown_;
    std::map<SessionId, Follower> followers_;
    SessionId latest_ = 0;  // whose view changed last
};

}  // namespace mote::server
