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
#include <asio/experimental/as_tuple.hpp>
#include <asio/steady_timer.hpp>
#include <asio/use_awaitable.hpp>
#include <atomic>
#include <chrono>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "protocol/wire/message_stream.h"
#include "protocol/wire/silence.h"
#include "server/data/dataset_service.h"
#include "server/frames/crash_record.h"
#include "server/frames/render_service.h"
#include "server/jobs/job_service.h"
#include "server/jobs/uploads.h"
#include "server/log.h"
#include "server/metrics/metrics.h"
#include "server/numbers/query_service.h"
#include "server/session/flow_control.h"
#include "server/session/following.h"
#include "server/session/message_account.h"
#include "server/session/outbox.h"
#include "server/session/parked_sessions.h"
#include "server/session/role.h"
#include "server/session/session_queries.h"

namespace mote::server {

/// Wakeup: a condition variable for coroutines of one thread. A coroutine waits in a loop that asks for what
/// it waits for; notify() wakes all that wait now. Nothing is lost, as nobody else runs between asking and
/// waiting.
class Wakeup {
  public:
    explicit Wakeup(const asio::any_io_executor& executor)
        : timer_(executor, asio::steady_timer::time_point::max()) {}

    void notify() { timer_.cancel(); }
    asio::awaitable<void> wait() {
        co_await timer_.async_wait(asio::experimental::as_tuple(asio::use_awaitable));
    }

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

/// What a client starts with.
std::uint32_t frameCredits(const proto::Hello& hello);

class Session : public std::enable_shared_from_this<Session> {
  public:
    Session(SessionId id, wire::MessageStream stream, SessionContext& context, Role role);

    /// `hello`: the first message, whose token is good. A session that goes on draws its view and tells its
    /// jobs at once. Throws where memory is short; the session is closed then.
    void start(const proto::ClientMessage& hello, const ParkedSessions::Admission& admission);
    /// Sends the client one fatal failure if it still takes it, then closes.
    void leave(const Error& reason);
    /// Whether nothing comes of it any more; nobody need keep it.
    bool closed() const { return closed_; }
    /// Closes where memory was too short to tell the client what it waits for: it comes back and asks again.
    void closeIfInVain();
    /// The datasets are not the same as before.
    void catalogueChanged();
    /// What a job is now.
    void jobChanged(std::shared_ptr<const proto::JobStatus> job);

  private:
    static constexpr std::size_t maxCommands = 8;
    static constexpr std::size_t maxCommandBytes = 2 << 20;  ///< in memory, from which on there is no room

    void spawnAll();
    asio::awaitable<void> runOrClose(asio::awaitable<void> (Session::*coroutine)());
    asio::awaitable<void> read();
    void welcome(const proto::ClientMessage& hello, const ParkedSessions::Admission& admission);
    asio::awaitable<void> goOn();
    void beginLife(const proto::Hello& hello);
    void lookLater();
    void look();
    void noteWish(const proto::ClientMessage& message);
    void noteNews(const proto::ServerMessage& message);
    asio::awaitable<void> handle(proto::ClientMessage message);
    asio::awaitable<void> setView(std::uint64_t request, const proto::SetView& message);
    void drawFollowed(const proto::SetView& message);
    void draw(std::shared_ptr<ViewTask> task);
    Status allowed(const proto::ClientMessage& message) const;
    void listSessions(std::uint64_t request);
    void follow(std::uint64_t request, SessionId whom);
    void show(const proto::Followed& followed);
    Status beware(ViewTask& task) const;
    asio::awaitable<Status> findDatasets(const View& view);
    /// Whom the datasets' thread answers; `wake`: of the coroutine that waits, a member.
    template <class Answer>
    Asker<Answer> asker(std::shared_ptr<std::optional<Answer>> answer, Wakeup& wake);
    /// Until the disk was looked at. Errors: as DatasetService::rescan, cancelled ("connection").
    asio::awaitable<Status> rescan(Wakeup& wake);
    void returnCredit(const proto::Credit& message);
    void begin(const proto::Hello& hello);
    void beginFrames();
    RenderEvents renderEvents();
    void frameReady(RenderedFrame frame);
    Outbox::Dropped dropped();
    void dropStaleFrames();
    void viewFailed(std::uint64_t request, bool queued, const Error& error);

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
    asio::awaitable<proto::ServerMessage> describe(const std::string& dataset);
    JobService::Question jobQuestion(proto::ClientMessage& command);
    JobService::Question submitJob(proto::SubmitJob& message) const;
    JobService::Question upload(proto::Upload& message) const;
    /// Until it is replied to; `wake`: of the coroutine that waits, a member.
    asio::awaitable<void> askJobs(std::uint64_t request, JobService::Question question, Wakeup& wake);
    void replyOfJobs(std::uint64_t request, Result<proto::ServerMessage> answer);
    asio::awaitable<Reply> fetchFilm(const proto::FetchFilm& request);

    asio::awaitable<void> query(proto::ClientMessage message);
    asio::awaitable<void> handOnAnswers();

    asio::awaitable<void> write();
    std::size_t piece(const RenderedFrame& frame, std::size_t begin, std::size_t left) const;
    void fill(Outbox::Item& item);
    void fillFrame(Outbox::Item& item);
    void reply(std::uint64_t to, Reply reply);
    void sayFarewell(const Error& reason);
    void close();
    /// Memory that is short ends this connection, not the server; the client comes back and asks again for
    /// what it would wait for in vain.
    template <class Work>
    void orClose(Work work) {
        try {
            work();
        } catch (const std::exception& failure) {
            log::failure("a session cannot go on", failure);
            close();
        }
    }

    const SessionId id_;
    SessionContext& context_;
    const Role role_;
    asio::any_io_executor executor_;
    wire::MessageStream stream_;
    asio::steady_timer deadline_;  // of the farewell
    asio::steady_timer pace_;      // when the link is ready for more
    asio::steady_timer life_;      // when to look whether the client is still there
    wire::Silence silence_{std::chrono::milliseconds(0), {}};
    std::chrono::milliseconds idle_{0};
    Clock::time_point lastWish_;  // or what the client was told that it waits for

    Wakeup readerWake_, workerWake_, writerWake_, answersWake_;
    Outbox outbox_;
    MessageAccount commandAccount_;
    std::deque<Command> commands_;
    SessionQueries queries_;
    std::shared_ptr<Uploads> uploads_;  // of the jobs' thread
    std::uint64_t sequence_ = 0;        // of the latest frame
    std::optional<FlowControl> flow_;   // once it is known what the client can do
    EncodingTarget target_;
    std::uint64_t viewId_ = 0;  // of the latest view that replaced those before it
    bool watchesJobs_ = false;
    proto::Followed followed_;
    std::uint64_t followRequest_ = 0;                  // that failures of followed views answer
    std::uint64_t followReply_ = 0;                    // not answered yet
    std::optional<proto::ClientMessage> resumedView_;  // as the client would ask for it
    /// What the client waits for was lost; set on any thread, which need have no memory for that.
    const std::shared_ptr<std::atomic<bool>> inVain_ = std::make_shared<std::atomic<bool>>(false);
    bool leaving_ = false;
    bool closed_ = false;
};

}  // namespace mote::server
