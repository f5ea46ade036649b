// SPDX-License-Identifier: GPL-3.0-or-later
//
// Outbox: what waits to be sent to one client, of bounded size whatever the client does: replies (whoever
// fills them waits for room()), the failure of the latest view, the jobs and the catalogue that changed (once
// each, however often), and as many frames as there are credits. One owner, one thread.
#pragma once

#include <deque>
#include <optional>
#include <set>
#include <string>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "server/session/render_service.h"

namespace mote::server {

proto::ServerMessage failureMessage(std::uint64_t replyTo, const Error& error, bool fatal);

class Outbox {
  public:
    static constexpr std::size_t maxReplies = 16;
    static constexpr std::size_t maxChangedJobs = 256;

    /// What is to be sent next; of jobs and the catalogue only that they changed, as their state is taken
    /// when it is sent.
    struct Item {
        enum class Kind { message, job, allJobs, catalogue, frame, farewell };
        Kind kind = Kind::message;
        proto::ServerMessage message;  ///< message, farewell
        std::string job;               ///< job: its id
        RenderedFrame frame;           ///< frame
    };

    bool room() const { return replies_.size() < maxReplies; }
    void reply(proto::ServerMessage message) { replies_.push_back(std::move(message)); }
    void viewFailed(proto::ServerMessage message) { viewFailure_ = std::move(message); }
    void jobChanged(const std::string& id);
    void catalogueChanged() { catalogue_ = true; }
    void frame(RenderedFrame frame) { frames_.push_back(std::move(frame)); }
    /// The last thing that is sent, before all that waits.
    void farewell(proto::ServerMessage message);

    std::size_t frames() const { return frames_.size(); }
    std::optional<Item> next();

  private:
    std::deque<proto::ServerMessage> replies_;
    std::optional<proto::ServerMessage> viewFailure_;
    std::optional<proto::ServerMessage> farewell_;
    std::set<std::string> jobs_;
    bool allJobs_ = false;
    bool catalogue_ = false;
    std::deque<RenderedFrame> frames_;
};

}  // namespace mote::server
