// SPDX-License-Identifier: GPL-3.0-or-later
//
// Outbox: what waits to be sent to one client, of bounded size whatever the client does: replies (whoever
// fills them waits for room()), among them the failures of queued views, which are few; the failure of the
// latest view, the jobs and the catalogue that changed (once each, however often), and as many frames as flow
// control allows. Of frames that nobody waits for, one that was not begun to be sent goes where a newer one
// is there, and where it grew old behind a client that did not read. One owner, one thread; knows no clock.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "server/data/held_memory.h"
#include "server/frames/render_service.h"

namespace mote::server {

/// Reply: an answer to a request, with the bytes that go with it; mostly none. A value.
struct Reply {
    Reply(proto::ServerMessage text) : message(std::move(text)) {}
    Reply(proto::ServerMessage text, std::vector<std::uint8_t> bytes)
        : message(std::move(text)), payload(std::move(bytes)) {}

    /// What it takes in memory: a list of jobs, with the ends of their logs, takes megabytes.
    std::size_t bytes() const { return payload.capacity() + message.SpaceUsedLong(); }

    proto::ServerMessage message;
    std::vector<std::uint8_t> payload;
    HeldMemory held = {};  ///< of its bytes, while it waits
};

proto::ServerMessage failureMessage(std::uint64_t replyTo, const Error& error, bool fatal);

class Outbox {
  public:
    static constexpr std::size_t maxReplies = 16;
    static constexpr std::size_t maxReplyBytes = 1 << 20;  ///< in memory, from which on there is no room
    static constexpr std::size_t maxChangedJobs = 256;

    /// What is to be sent next; of all jobs, the catalogue and whom it follows only that they changed, as
    /// their state is taken when it is sent.
    struct Item {
        enum class Kind { message, job, allJobs, catalogue, followed, frame, farewell };
        Kind kind = Kind::message;
        proto::ServerMessage message = {};       ///< message, farewell
        std::vector<std::uint8_t> payload = {};  ///< message
        std::shared_ptr<const proto::JobStatus> job = {};
        std::shared_ptr<const RenderedFrame> frame = {};  ///< frame: kept while a piece of it is written
        std::size_t begin = 0, size = 0;                  ///< frame: the piece of its payload
    };
    /// How many bytes of a frame may be sent now, of those that are `left` from `begin` on.
    using Piece = std::function<std::size_t(const RenderedFrame&, std::size_t begin, std::size_t left)>;

    bool room() const { return replies_.size() < maxReplies && replyBytes_ < maxReplyBytes; }
    void reply(Reply reply);
    void viewFailed(proto::ServerMessage message) { viewFailure_ = std::move(message); }
    void jobChanged(std::shared_ptr<const proto::JobStatus> job);
    /// A reply is there that knows all changes until now: those of its jobs need not be told.
    void jobsTold(const proto::ServerMessage& reply);
    void allJobsChanged();
    void catalogueChanged() { catalogue_ = true; }
    void followedChanged() { followed_ = true; }
    /// A frame was dropped: whether a part of it was sent, and whether others after it need it.
    using Dropped = std::function<void(bool partlySent, bool ofStream)>;
    /// `dropped`: of those that it takes the place of.
    void frame(RenderedFrame frame, Clock::time_point now, const Dropped& dropped);
    /// Frames that a newer view makes worthless.
    void dropOutdated(const Dropped& dropped);
    /// Frames in motion that wait since before `since` and are not of view `latest`.
    void dropStale(Clock::time_point since, std::uint64_t latest, const Dropped& dropped);
    /// The last thing that is sent, before all that waits.
    void farewell(proto::ServerMessage message);

    std::size_t frames() const { return frames_.size(); }
    /// Whether a frame waits that a newer one would take the place of.
    bool anyReplaceable() const;
    std::optional<Item> next(const Piece& piece);

  private:
    /// A frame, and how much of its payload was handed out.
    struct Waiting {
        std::shared_ptr<const RenderedFrame> frame;
        Clock::time_point since;
        std::size_t begin = 0;

        /// Of a hand in motion, nothing of it sent: another may take its place.
        bool replaceable() const { return begin == 0 && frame->quick && !frame->wanted; }
        /// Of pictures that are told by those before them.
        bool ofStream() const { return frame->message.encoding() == proto::Frame::H264; }
    };
    bool orphan(const Waiting& waiting) const;
    template <class Condition>
    void drop(Condition condition, const Dropped& dropped);
    std::optional<Item> nextPiece(const Piece& piece);

    std::deque<Reply> replies_;
    std::size_t replyBytes_ = 0;  // in memory
    std::optional<proto::ServerMessage> viewFailure_;
    std::optional<proto::ServerMessage> farewell_;
    std::map<std::string, std::shared_ptr<const proto::JobStatus>> jobs_;  // what they are now, by id
    bool allJobs_ = false;
    bool catalogue_ = false;
    bool followed_ = false;
    std::deque<Waiting> frames_;
    bool needsKey_ = false;  // one of the stream was dropped, and those after it tell nothing without it
};

}  // namespace mote::server
