// SPDX-License-Identifier: GPL-3.0-or-later
//
// What stands behind Connection: the I/O thread, and the state that it shares with the owner's threads.
// Members under "shared" are guarded by mutex_; those under "I/O thread" are touched there only.
#pragma once

#include <asio/executor_work_guard.hpp>
#include <asio/io_context.hpp>
#include <asio/steady_timer.hpp>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <thread>

#include "client/shared/connection.h"
#include "client/shared/frame_assembly.h"
#include "client/shared/inbox.h"
#include "client/shared/line.h"
#include "client/shared/sliding_rate.h"

namespace mote::client {

class Connection::Impl {
  public:
    using Answer = std::function<void(Result<proto::ServerMessage>)>;
    using Body = proto::ServerMessage::BodyCase;

    Impl(std::filesystem::path connectionFile, ConnectionSettings settings);
    ~Impl();

    State state() const;
    std::optional<Error> lostReason() const;
    proto::Welcome welcome() const;
    ConnectionStatistics statistics() const;
    void reconnect();
    std::size_t poll();
    bool wait(std::chrono::milliseconds timeout);
    std::uint64_t setView(proto::View view, const ViewRequest& request);
    std::optional<ReceivedFrame> takeFrame();
    /// `answer` runs inside poll().
    void ask(proto::ClientMessage question, Body expected, Answer answer);

    // Set before the first poll, run inside it.
    std::function<void(State)> stateListener;
    std::function<void(const proto::Catalogue&)> catalogueListener;
    std::function<void(const proto::JobStatus&)> jobListener;
    std::function<void(std::uint64_t, const Error&)> viewListener;

  private:
    struct Question {
        Body expected;
        Answer answer;
        proto::ClientMessage message;
        bool sent = false;
    };
    /// A line that broke is opened again.
    struct Returning {
        Error reason;
        std::chrono::steady_clock::time_point until;
    };
    struct WantedView {
        proto::SetView message;
        bool sent = false;
    };

    // I/O thread.
    void connect();
    void prepareLine();
    void lost(const Error& reason);
    void comeBack();
    void openLine(const proto::ConnectionFile& server);
    void drop(Error reason);
    std::optional<proto::ClientMessage> next();
    void received(proto::ServerMessage message, std::vector<std::uint8_t> payload);
    void welcomed(const proto::ServerMessage& message);
    void receivedPiece(proto::Frame message, std::vector<std::uint8_t> payload);
    void receivedFrame(WholeFrame whole);
    void frameFailed(std::uint64_t viewId, const Error& error);
    void receivedFailure(const proto::ServerMessage& message);
    void answered(proto::ServerMessage message);
    void watchTime(std::chrono::milliseconds wait);
    void tick();
    void wakeWriter();

    // With mutex_ held.
    void setState(State state);
    void push(std::string key, Inbox::Callback callback);
    void giveBackFrame();
    std::optional<proto::ClientMessage> nextCredit();
    void failAll(const Error& reason);
    void failSent(const Error& reason);
    void askAgain(const Error& reason);
    proto::ClientMessage nextQuestion();
    std::optional<proto::ClientMessage> nextView();
    void receivedNews(proto::ServerMessage message);
    void viewFailed(std::uint64_t viewId, const Error& error);
    std::uint64_t viewOfRequest(std::uint64_t request) const;

    void notify();

    const std::filesystem::path connectionFile_;
    const ConnectionSettings settings_;

    // Shared.
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    State state_ = State::connecting;
    std::optional<Error> lostReason_;
    proto::Welcome welcome_;
    Inbox inbox_;
    std::optional<ReceivedFrame> frame_;
    std::optional<WantedView> view_;
    std::uint64_t lastViewId_ = 0;
    std::uint64_t lastRequest_ = 0;
    proto::Credit credit_;  // to give back, and to say
    bool creditDue_ = false;
    std::deque<proto::ClientMessage> outbox_;
    std::map<std::uint64_t, Question> questions_;                    // asked and not answered, by request
    std::deque<std::pair<std::uint64_t, std::uint64_t>> sentViews_;  // request, view id; the latest ones
    mutable SlidingRate frameRate_, byteRate_;
    ConnectionStatistics totals_;
    std::optional<std::chrono::steady_clock::time_point> pingSince_;  // our own, unanswered

    // I/O thread.
    std::shared_ptr<Line> line_;
    bool welcomed_ = false;
    bool ending_ = false;
    std::optional<Returning> returning_;  // until a line has held for a while
    std::chrono::steady_clock::time_point welcomedAt_;
    bool saysReceipts_ = false;        // to a server that understands them
    std::uint64_t receivedBytes_ = 0;  // of payloads of frames, on this line
    FrameAssembly assembly_;
    std::optional<FrameDecoder> decoder_;
    std::optional<proto::ClientMessage> hello_;
    asio::io_context context_{1};
    asio::steady_timer timer_{context_};
    asio::executor_work_guard<asio::io_context::executor_type> work_{context_.get_executor()};
    std::thread thread_;
};

}  // namespace mote::client
