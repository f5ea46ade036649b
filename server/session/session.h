// SPDX-License-Identifier: GPL-3.0-or-later
//
// Session: one known client's connection, from its hello to its end. Four coroutines on the server's thread:
// one reads (state at once, commands into a short queue), one works on the commands in order, one writes. All
// that a session holds is bounded; where a client does not read, its own reader stops and nobody else
// notices.
//
// Owned by the server and by its coroutines, by shared pointer. All functions on the server's thread.
#pragma once

#include <asio/any_io_executor.hpp>
#include <asio/awaitable.hpp>
#include <asio/steady_timer.hpp>
#include <chrono>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/wire/await_tuple.h"
#include "protocol/wire/message_stream.h"
#include "server/data/dataset_service.h"
#include "server/frames/crash_record.h"
#include "server/frames/render_service.h"
#include "server/jobs/job_service.h"
#include "server/jobs/uploads.h"
#include "server/metrics/metrics.h"
#include "server/numbers/query_service.h"
#include "server/session/client_life.h"
#include "server/session/following.h"
#include "server/session/frame_sender.h"
#include "server/session/message_account.h"
#include "server/session/outbox.h"
#include "server/session/parked_sessions.h"
#include "server/session/role.h"
#include "server/session/session_queries.h"
#include "server/session/thumbnails.h"

namespace mote::server {

/// Wakeup: a condition variable for coroutines of one thread. A coroutine waits in a loop that asks for what
/// it waits for; notify() wakes all that wait now. Nothing is lost, as nobody else runs between asking and
/// waiting.
class Wakeup {
  public:
    explicit Wakeup(const asio::any_io_executor& executor)
        : timer_(executor, asio::steady_timer::time_point::max()) {}

    void notify() { timer_.cancel(); }
    asio::awaitable<void> wait() { co_await timer_.async_wait(wire::awaitTuple); }

  private:
    asio::steady_timer timer_;
};

/// What sessions share; the server owns it and outlives them.
struct SessionContext {
    std::string token;
    std::string followerToken;  ///< of those who only follow; empty: there are none
    std::string server;         ///< program and version
    std::string device;
    RenderService* render = nullptr;
    DatasetService* datasets = nullptr;
    JobService* jobs = nullptr;
    QueryService* queries = nullptr;       ///< null: none are answered
    Thumbnails* thumbnails = nullptr;      ///< null: none are made
    std::filesystem::path uploads;         ///< Uploads::makeFolder; empty: none are taken
    Uploads::Remove removeUploads = {};    ///< a client's, when it leaves; empty: at once
    const CrashRecord* crashes = nullptr;  ///< null: nothing is known
    ParkedSessions* parked = nullptr;      ///< outlives the sessions
    Following* following = nullptr;        ///< outlives the sessions
    std::shared_ptr<Metrics> metrics = std::make_shared<Metrics>();
    std::chrono::milliseconds silence{30'000};        ///< of a client's, that ends its session; 0: none
    std::chrono::milliseconds idle{0};                ///< without a wish, that ends a session; 0: none
    std::chrono::milliseconds staleAfter{250};        ///< a frame in motion that waited so long is old
    std::chrono::milliseconds farewellTimeout{1000};  ///< a client has this long to take the last word
    std::function<void(SessionId)> closed;            ///< once, as the last thing
};

/// A list for those who watch jobs; a question of the jobs' thread.
Result<proto::ServerMessage> allJobs(JobQueue& queue);

class Session : public std::enable_shared_from_this<Session> {
  public:
    Session(SessionId id, wire::MessageStream stream, SessionContext& context, Role role);

    /// `hello`: the first message, whose token is good. A session that goes on draws its view and tells its
    /// jobs at once.
    void start(const proto::ClientMessage& hello, const ParkedSessions::Admission& admission);
    /// Sends the client one fatal failure if it still takes it, then closes.
    void leave(const Error& reason);
    /// The datasets are not the same as before.
    void catalogueChanged();
    /// What a job is now.
    void jobChanged(std::shared_ptr<const proto::JobStatus> job);

  private:
    static constexpr std::size_t maxCommands = 8;
    static constexpr std::size_t maxCommandBytes = 2 << 20;  ///< in memory, from which on there is no room

    asio::awaitable<void> runOrClose(asio::awaitable<void> (Session::*coroutine)());
    asio::awaitable<void> read();
    void welcome(const proto::ClientMessage& hello, const ParkedSessions::Admission& admission);
    asio::awaitable<void> goOn();
    void lookLater();
    void look();
    asio::awaitable<void> handle(proto::ClientMessage message);
    asio::awaitable<void> setView(std::uint64_t request, const proto::SetView& message);
    void listSessions(std::uint64_t request);
    void follow(std::uint64_t request, SessionId whom);
    void show(const proto::Followed& followed);
    asio::awaitable<Status> findDatasets(const View& view);
    asio::awaitable<Status> rescan();

    /// A command, until it is answered.
    struct Command {
        proto::ClientMessage message;
        MessageAccount::Hold hold;
    };
    bool commandsHaveRoom() const { return commands_.size() < maxCommands && commandAccount_.room(); }
    asio::awaitable<void> work();
    asio::awaitable<void> workOn(proto::ClientMessage& command);
    asio::awaitable<Reply> answer(const proto::ClientMessage& command);
    asio::awaitable<proto::ServerMessage> listDatasets();
    asio::awaitable<proto::ServerMessage> listFolder(const proto::ListFolder& wanted);
    asio::awaitable<proto::ServerMessage> describe(const std::string& dataset);
    asio::awaitable<void> askJobs(std::uint64_t request, JobService::Question question);
    asio::awaitable<Reply> fetchArtifact(const proto::FetchFilm& request);

    asio::awaitable<void> query(proto::ClientMessage message);
    asio::awaitable<void> thumbnail(std::uint64_t request, const std::string& dataset);
    asio::awaitable<void> handOnAnswers();
    bool handOnThumbnail();
    void lookAtFile(std::uint64_t request, const proto::LookAtFile& wanted);
    void endLook();
    void cancelLook(std::uint64_t request);

    asio::awaitable<void> write();
    void fill(Outbox::Item& item);
    void reply(std::uint64_t to, Reply reply);
    void refuse(std::uint64_t to, const Error& error);
    void close();

    const SessionId id_;
    SessionContext& context_;
    const Role role_;
    asio::any_io_executor executor_;
    wire::MessageStream stream_;
    asio::steady_timer deadline_;  // of the farewell
    asio::steady_timer lookAt_;    // whether the client is still there
    ClientLife life_;

    Wakeup readerWake_, workerWake_, writerWake_, answersWake_;
    Outbox outbox_;
    const std::shared_ptr<FrameSender> frames_;
    MessageAccount commandAccount_;
    std::deque<Command> commands_;
    SessionQueries queries_;
    SessionThumbnails thumbnails_;
    struct FileLook {
        std::uint64_t request;
        LookRuns::Ticket ticket;
    };
    std::optional<FileLook> fileLook_;  // at a file, under way
    std::shared_ptr<Uploads> uploads_;  // of the jobs' thread
    bool watchesJobs_ = false;
    proto::Followed followed_;
    std::uint64_t followRequest_ = 0;                  // that failures of followed views answer
    std::uint64_t followReply_ = 0;                    // not answered yet
    std::optional<proto::ClientMessage> resumedView_;  // as the client would ask for it
    bool leaving_ = false;
    bool closed_ = false;
};

}  // namespace mote::server
