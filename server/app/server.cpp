// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/server.h"

#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <asio/io_context.hpp>
#include <asio/local/stream_protocol.hpp>
#include <asio/post.hpp>
#include <asio/signal_set.hpp>
#include <asio/steady_timer.hpp>
#include <csignal>
#include <cstring>
#include <map>
#include <optional>

#include "protocol/wire/address.h"
#include "protocol/wire/connection_file.h"
#include "server/app/connection_claim.h"
#include "server/app/socket_place.h"
#include "server/data/data_memory.h"
#include "server/log.h"
#include "server/session/session.h"
#include "server/session/token.h"

namespace mote::server {
namespace {

using Protocol = asio::local::stream_protocol;
using namespace std::chrono_literals;

// After an error that is not the client's (no descriptors left, say), accepting again at once would spin.
constexpr auto acceptPause = 200ms;

JobSettings jobSettings(const ServerSettings& settings) {
    JobSettings jobs;
    jobs.stateDirectory = settings.stateDirectory;
    jobs.prep = settings.prep;
    jobs.roots = settings.roots;
    jobs.memory = settings.memory;
    jobs.threads = settings.threads;
    return jobs;
}

}  // namespace

class Server::Impl {
  public:
    Impl(ServerSettings settings, DeviceFactory device)
        : settings_(std::move(settings)), device_(std::move(device)) {}

    ~Impl() {
        withdraw();
        if (jobs_) jobs_->stop();
        render_.reset();
        datasets_.reset();
    }

    Status start() {
        MOTE_ASSIGN_OR_RETURN(auto roots, storage::Roots::parse(settings_.roots));
        MOTE_RETURN_IF_ERROR(checkNotInUse(settings_.connectionFile));
        jobs_.emplace(io_, jobSettings(settings_));
        MOTE_RETURN_IF_ERROR(jobs_->start());
        jobs_->onChange([this](const proto::JobStatus& job) { jobChanged(job); });
        const auto memory = dataMemory(settings_.memory);
        if (!memory.ok()) return memory.error().within("memory");
        datasets_ = std::make_unique<DatasetService>(
            std::move(roots), [this] { asio::post(io_, [this] { catalogueChanged(); }); }, *memory,
            [this] { asio::post(io_, [this] { render_->dataArrived(); }); });
        datasets_->rescan();
        render_ = std::make_unique<RenderService>(device_, *datasets_, settings_.render);
        MOTE_ASSIGN_OR_RETURN(const auto name, render_->start());
        fillContext(name);
        if (settings_.stopOnSignals) stopOnSignals();
        MOTE_RETURN_IF_ERROR(listen());
        return writeFile();
    }

    void run() {
        accept();
        rescanLater();
        for (;;) {
            try {
                io_.run();
                return;
            } catch (const std::exception& failure) {
                // Memory was short, say: what was being done is lost, the server is not.
                log::error("{}", failure.what());
            }
        }
    }

    void stop() {
        asio::post(io_, [this] { stopNow(); });
    }

    void withdraw() {
        removeIfOurs(settings_.connectionFile, context_.token);
        place_.reset();
    }

    const std::string& deviceName() const { return context_.device; }

  private:
    /// Before there is anything that a killed server would leave behind. Who started us under nohup wants no
    /// SIGHUP.
    void stopOnSignals() {
        struct sigaction hangUp {};
        ::sigaction(SIGHUP, nullptr, &hangUp);
        signals_.emplace(io_, SIGTERM, SIGINT);
        if (hangUp.sa_handler != SIG_IGN) signals_->add(SIGHUP);
        signals_->async_wait([this](const asio::error_code& code, int number) {
            if (code) return;
            log::info("SIG{}: the server ends", ::sigabbrev_np(number));
            stopNow();
        });
    }

    void fillContext(const std::string& deviceName) {
        context_.token = settings_.token.empty() ? makeToken() : settings_.token;
        context_.server = "mote-server " MOTE_VERSION;
        context_.device = deviceName;
        context_.render = render_.get();
        context_.datasets = datasets_.get();
        context_.jobs = &*jobs_;
        context_.crashes = settings_.render.crashes;
        context_.handshakeTimeout = settings_.handshakeTimeout;
        context_.closed = [this](SessionId id) {
            // Later: the session that says so is in the midst of its own function.
            asio::post(io_, [this, id] {
                sessions_.erase(id);
                if (stopping_ && sessions_.empty()) io_.stop();
            });
        };
    }

    Status listen() {
        MOTE_ASSIGN_OR_RETURN(auto place, SocketPlace::make(settings_.stateDirectory));
        place_.emplace(std::move(place));
        asio::error_code code;
        acceptor_.open(Protocol(), code);
        // The socket must never be there for others, not even between two calls.
        const mode_t mask = ::umask(0177);
        if (!code) acceptor_.bind(Protocol::endpoint(place_->path().string()), code);
        ::umask(mask);
        if (!code) acceptor_.listen(Protocol::acceptor::max_listen_connections, code);
        if (!code) return success();
        return Error{ErrorCode::internal, place_->path().string(), "cannot listen: " + code.message()};
    }

    Status writeFile() {
        proto::ConnectionFile file;
        file.set_address("unix:" + place_->path().string());
        file.set_token(context_.token);
        file.set_pid(::getpid());
        file.set_protocol_major(wire::ownVersion.major);
        file.set_protocol_minor(wire::ownVersion.minor);
        return wire::writeConnectionFile(settings_.connectionFile, file);
    }

    void accept() {
        acceptor_.async_accept([this](const asio::error_code& code, Protocol::socket socket) {
            if (code == asio::error::operation_aborted || stopping_) return;
            if (!code) {
                begin(std::move(socket));
                return accept();
            }
            log::error("a client cannot be accepted: {}", code.message());
            pause_.expires_after(acceptPause);
            pause_.async_wait([this](const asio::error_code& cancelled) {
                if (!cancelled && !stopping_) accept();
            });
        });
    }

    void begin(Protocol::socket socket) {
        if (sessions_.size() >= settings_.maxSessions) return turnAway(std::move(socket));
        const SessionId id = ++lastSession_;
        auto session = std::make_shared<Session>(id, std::move(socket), context_);
        sessions_.emplace(id, session);
        session->start();
        datasets_->rescan();
    }

    /// It costs nothing but this: greeting and failure fit into the empty buffer of a new connection.
    void turnAway(Protocol::socket socket) {
        log::warn("a client was turned away: {} are connected", sessions_.size());
        const Error reason{ErrorCode::resourceExhausted, "server",
                           "it has as many clients as it takes; close one of them"};
        std::vector<std::uint8_t> frame;
        const auto status = wire::encodeFrame(failureMessage(0, reason, true), 0, wire::serverLimits, frame);
        if (!status.ok()) return;
        const auto greeting = wire::encodeGreeting(wire::ownVersion);
        const std::array<asio::const_buffer, 2> bytes{asio::buffer(greeting), asio::buffer(frame)};
        asio::error_code ignored;
        socket.non_blocking(true, ignored);
        socket.write_some(bytes, ignored);
    }

    void rescanLater() {
        // A slow disk is not kept busy: a twentieth of the time at most.
        rescan_.expires_after(
            std::max<Clock::duration>(settings_.rescanInterval, 20 * datasets_->lookTime()));
        rescan_.async_wait([this](const asio::error_code& code) {
            if (code || stopping_) return;
            if (!sessions_.empty()) datasets_->rescan();
            rescanLater();
        });
    }

    void catalogueChanged() {
        for (const auto& [id, session] : sessions_) session->catalogueChanged();
    }

    void jobChanged(const proto::JobStatus& job) {
        if (job.state() == proto::JobStatus::SUCCEEDED) datasets_->rescan();
        for (const auto& [id, session] : sessions_) session->jobChanged(job);
    }

    /// Sessions have a second for their last word; then nothing is left that run() waits for.
    void stopNow() {
        if (std::exchange(stopping_, true)) return;
        asio::error_code ignored;
        acceptor_.close(ignored);
        if (signals_) signals_->cancel(ignored);
        rescan_.cancel();
        pause_.cancel();
        jobs_->stop();
        for (const auto& [id, session] : sessions_) {
            session->leave({ErrorCode::cancelled, "server", "the server ends"});
        }
        finish_.expires_after(2 * context_.farewellTimeout);
        finish_.async_wait([this](const asio::error_code&) { io_.stop(); });
        if (sessions_.empty()) io_.stop();
    }

    const ServerSettings settings_;
    const DeviceFactory device_;
    asio::io_context io_{1};  // before all that posts to it
    std::optional<SocketPlace> place_;
    Protocol::acceptor acceptor_{io_};
    std::optional<asio::signal_set> signals_;
    asio::steady_timer rescan_{io_}, pause_{io_}, finish_{io_};
    std::optional<JobQueue> jobs_;
    std::unique_ptr<DatasetService> datasets_;
    std::unique_ptr<RenderService> render_;
    SessionContext context_;
    std::map<SessionId, std::shared_ptr<Session>> sessions_;
    SessionId lastSession_ = 0;
    bool stopping_ = false;
};

Server::Server(ServerSettings settings, DeviceFactory device)
    : impl_(std::make_unique<Impl>(std::move(settings), std::move(device))) {}
Server::~Server() = default;

Status Server::start() {
    return impl_->start();
}
void Server::run() {
    impl_->run();
}
void Server::stop() {
    impl_->stop();
}
void Server::withdraw() {
    impl_->withdraw();
}
std::string Server::deviceName() const {
    return impl_->deviceName();
}

}  // namespace mote::server
