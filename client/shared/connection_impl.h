// SPDX-License-Identifier: GPL-3.0-or-later
//
// What stands behind Connection: the I/O thread, and the state that it shares with the owner's threads.
// Members under "shared" are guarded by mutex_; those under "I/O thread" are touched there only.
#pragma once

#include <asio/any_io_executor.hpp>
#include <asio/awaitable.hpp>
#include <asio/executor_work_guard.hpp>
#include <asio/io_context.hpp>
#include <asio/steady_timer.hpp>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <vector>

#include "client/shared/connection.h"
#include "client/shared/connection_parts.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/wire/address.h"
#include "protocol/wire/message_stream.h"
#include "protocol/wire/silence.h"

namespace mote::client {

/// What a line asks of its owner; called on the I/O thread, never after close().
struct LineHandlers {
    /// The next message to send; empty: nothing now. Asked only when the one before it is on its way, so that
    /// what is not asked for yet can still be replaced.
    std::function<std::optional<proto::ClientMessage>()> next;
    std::function<void(proto::ServerMessage, std::vector<std::uint8_t> payload)> received;
    /// There is no server, or the line is closed by it or broken; once.
    std::function<void(Error)> lost;
};

/// One connected socket, from connect() to its end, never reused. It knows nothing of what messages mean.
/// Owned by shared pointer, so that its coroutines outlive a close(); I/O thread only.
class Line : public std::enable_shared_from_this<Line> {
  public:
    Line(const asio::any_io_executor& executor, LineHandlers handlers);

    /// Connects to a server's socket and greets; then reads and writes until close() or lost. `fingerprint`:
    /// of the certificate, with TCP.
    void open(const wire::Address& address, std::string fingerprint);
    /// next() has something.
    void wakeWriter();
    /// As MessageStream::progress().
    std::uint64_t progress() const { return stream_.progress(); }
    void close();

  private:
    asio::awaitable<void> run(wire::Address address, std::string fingerprint);
    asio::awaitable<Status> connectUnix(const wire::Address& address);
    asio::awaitable<Status> connectTcp(const wire::Address& address, std::string fingerprint);
    asio::awaitable<void> readAll();
    asio::awaitable<void> writeAll();
    void fail(const Error& error);

    LineHandlers handlers_;
    wire::MessageStream stream_;
    asio::steady_timer writerSleep_;
    bool closed_ = false;
};

struct Connection::Impl {
    struct ServerAnswer {
        proto::ServerMessage message;
        std::vector<std::uint8_t> payload = {};
    };
    using Answer = std::function<void(Result<ServerAnswer>)>;
    using Body = proto::ServerMessage::BodyCase;

    struct Question {
        Body expected;
        Answer answer;
        proto::ClientMessage message;
        bool sent = false;
        bool begun = false;  ///< answered in part
    };
    /// A line that broke is opened again.
    struct Returning {
        Error reason;
        std::chrono::steady_clock::time_point since;
        std::chrono::steady_clock::time_point until;
    };
    struct WantedView {
        proto::SetView message;
        bool sent = false;
    };

    Impl(std::filesystem::path connectionFile, ConnectionSettings settings);
    ~Impl();

    // Any thread.
    /// `answer` runs inside poll(). Returns the request; 0 if it was refused at once.
    std::uint64_t ask(proto::ClientMessage question, Body expected, Answer answer);
    void wakeWriter();
    void notify();

    // Set before the first poll, run inside it.
    std::function<void(State)> stateListener;
    std::function<void(const proto::Catalogue&)> catalogueListener;
    std::function<void(const proto::JobStatus&)> jobListener;
    std::function<void(std::uint64_t, const Error&)> viewListener;

    // I/O thread.
    void connect();
    void prepareLine();
    void lost(const Error& reason);
    void heardFarewell(const Error& reason);
    void returnFrom(Error reason);
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
    void answered(proto::ServerMessage message, std::vector<std::uint8_t> payload);
    void receivedPing(const proto::Ping& ping);
    void watchTime(std::chrono::milliseconds wait);
    void watchLife();
    void tick();

    // With mutex_ held.
    void setState(State state);
    void goOnWithView(std::uint64_t hello);
    void push(std::string key, Inbox::Callback callback);
    void giveBackFrame();
    std::optional<proto::ClientMessage> nextCredit();
    void failAll(const Error& reason);
    void failSent(const Error& reason);
    void askAgain(const Error& reason);
    proto::ClientMessage nextQuestion();
    std::optional<proto::ClientMessage> nextView();
    WantedView* unsentView();
    void keepFrame(ReceivedFrame frame);
    bool isQueued(std::uint64_t viewId) const;
    void answerQuestion(std::uint64_t request, Result<ServerAnswer> result);
    void receivedNews(proto::ServerMessage message);
    void viewFailed(std::uint64_t viewId, const Error& error);
    std::uint64_t viewOfRequest(std::uint64_t request) const;

    const std::filesystem::path connectionFile_;
    const ConnectionSettings settings_;

    // Shared.
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    State state_ = State::connecting;
    std::optional<Error> lostReason_;
    std::optional<Error> brokenBy_;  // while the line is opened again
    proto::Welcome welcome_;
    Inbox inbox_;
    std::optional<ReceivedFrame> frame_;      // of the present view, the newest
    std::deque<ReceivedFrame> queuedFrames_;  // of queued views
    std::optional<WantedView> view_;
    std::size_t staleFrames_ = 0;         // of these, that came on an earlier line
    std::deque<WantedView> queuedViews_;  // not answered yet
    std::uint64_t lastViewId_ = 0;
    std::uint64_t lastRequest_ = 0;
    std::set<std::uint64_t> cancelledQueries_;  // whose end was not heard
    /// Says by request whether answers that wait for poll() are still wanted; gone with the last of them.
    std::map<std::uint64_t, std::weak_ptr<std::atomic<bool>>> queriesWanted_;
    proto::Credit credit_;  // to give back, and to say
    bool creditDue_ = false;
    std::optional<proto::ClientMessage> pong_;  // that the server waits for
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
    std::chrono::steady_clock::time_point welcomedAt_, pingedAt_;
    std::string resume_;  // takes the session up again, once
    wire::Silence silence_{std::chrono::milliseconds(0), {}};
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
