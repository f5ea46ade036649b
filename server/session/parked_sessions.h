// SPDX-License-Identifier: GPL-3.0-or-later
//
// ParkedSessions: what of each session outlives its connection, by the secret that takes it up again. Those
// that are connected are here too, as nobody knows beforehand when a line breaks; the others are kept for a
// time. Bounded in number, in bytes and in time. Owned by the server; one thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "server/frames/view_task.h"
#include "server/jobs/uploads.h"

namespace mote::server {

struct ParkingLimits {
    std::size_t number = 256;                            ///< of sessions, the connected ones among them
    std::size_t bytes = std::size_t{8} << 20;            ///< of their views
    std::chrono::seconds kept{24 * 3600};                ///< after the connection's end
    std::chrono::seconds uploadsKept{60};                ///< likewise; clients try to come back for less
    std::uint64_t uploadBytes = std::uint64_t{1} << 34;  ///< of those without a connection, together
};

class ParkedSessions {
  public:
    using Time = Clock::time_point;

    /// What a session goes on with.
    struct State {
        std::optional<proto::SetView> view;  ///< the latest that was not queued
        bool watchesJobs = false;
        std::shared_ptr<Uploads> uploads = {};  ///< null: none
    };
    /// Who is let in, and with what.
    struct Admission {
        std::string secret;    ///< takes the session up again, once
        bool resumed = false;  ///< the session that was named goes on
        SessionId before = 0;  ///< its number until now
        State state = {};
    };

    /// `changed` is called when toBytes() would give something else.
    explicit ParkedSessions(
        ParkingLimits limits = {}, std::function<void()> changed = [] {})
        : limits_(limits), changed_(std::move(changed)) {}

    /// The number of the session that a secret takes up; nothing where it is no secret of ours. Takes the
    /// same time for each secret of one length, as sameToken().
    std::optional<SessionId> sessionOf(std::string_view secret) const;
    /// A connection becomes this session: one that goes on, where the secret is right, or a new one. The
    /// secret that was given stays good until confirm(), as the new one may be lost on its way. Throws where
    /// memory is short or the system has no random bytes.
    Admission admit(std::string_view secret, SessionId session, Time now);
    /// The client has the secret of its admission.
    void confirm(SessionId session);
    /// A view that finds no room is not kept, and none in its place.
    void setView(SessionId session, const proto::SetView& view);
    void watchJobs(SessionId session);
    void setUploads(SessionId session, std::shared_ptr<Uploads> uploads);
    /// Lets uploads go that were kept for long enough, or are too many. Of connected clients they stay.
    void sweepUploads(Time now);
    /// Its connection ended.
    void left(SessionId session, Time now);

    /// For a file: of each session the messages that would make it again, hello (with its
    /// secret) first, framed as on the wire.
    std::vector<std::uint8_t> toBytes() const;
    /// Adds what toBytes() gave, as sessions that have left now. Errors: corrupt; what was read until there
    /// stays.
    Status add(std::span<const std::uint8_t> bytes, Time now);

    std::size_t size() const { return entries_.size(); }

  private:
    struct Entry {
        SessionId session = 0;  ///< 0: of an earlier server
        std::string secret = {};
        std::string before = {};  ///< the secret that it was taken up with; empty: not good any more
        State state = {};
        std::size_t bytes = 0;  ///< of the view
        std::optional<Time> left = {};
    };

    Entry* find(SessionId session);
    const Entry* find(std::string_view secret) const;
    void forgetOld(Time now);
    bool forgetOne(SessionId keep);
    Entry* firstThatLeft(SessionId keep, bool withUploads);
    std::size_t bytes() const;

    ParkingLimits limits_;
    std::function<void()> changed_;
    std::vector<Entry> entries_;
};

}  // namespace mote::server
