// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/server.h"

#include <fmt/format.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <asio/io_context.hpp>
#include <asio/post.hpp>
#include <asio/signal_set.hpp>
#include <asio/steady_timer.hpp>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "protocol/base/system_error.h"
#include "protocol/wire/address.h"
#include "protocol/wire/connection_file.h"
#include "protocol/wire/private_file.h"
#include "server/app/entrance.h"
#include "server/app/http_listener.h"
#include "server/data/data_memory.h"
#include "server/log.h"
#include "server/metrics/exposition.h"
#include "server/session/parked_sessions.h"
#include "server/session/session.h"
#include "server/session/token.h"

namespace mote::server {
namespace {

unsigned processors(const ServerSettings& settings) {
    return settings.threads > 0 ? settings.threads : std::thread::hardware_concurrency();
}

JobSettings jobSettings(const ServerSettings& settings) {
    JobSettings jobs;
    jobs.stateDirectory = settings.stateDirectory;
    jobs.prep = settings.prep;
    jobs.frames = settings.frames;
    jobs.roots = settings.roots;
    jobs.memory = settings.memory;
    jobs.threads = settings.threads;
    jobs.runner = settings.runner;
    jobs.ranks = settings.jobRanks;
    jobs.running = settings.jobs;
    jobs.queued = settings.jobsWaiting;
    jobs.kept = settings.jobsKept;
    jobs.timeLimit = settings.jobTime;
    jobs.allowUnconfined = settings.allowUnconfinedJobs;
    return jobs;
}

/// More than limits allow: a file of this size is none of ours.
constexpr std::size_t mostParkedBytes = std::size_t{16} << 20;

/// ParkedFile: keeps what outlives connections in a file of the state directory, so that it outlives the
/// server. A change is written a moment later, with those that came meanwhile, on a thread of its own. Owned
/// by the server, on its thread.
class ParkedFile {
  public:
    /// Reads what an earlier server has left, as far as it can be read; call once the state directory's lock
    /// is held. `sessions` outlive it.
    ParkedFile(asio::io_context& io, const std::filesystem::path& stateDirectory,
               std::chrono::milliseconds pause, ParkedSessions& sessions);
    /// Writes what was not written yet, and waits for it.
    ~ParkedFile();
    ParkedFile(const ParkedFile&) = delete;
    ParkedFile& operator=(const ParkedFile&) = delete;

    /// The sessions are not the same as before.
    void changed();

  private:
    void read();
    void hand();
    void write();

    const std::filesystem::path file_;
    const std::chrono::milliseconds pause_;
    ParkedSessions& sessions_;
    asio::steady_timer timer_;
    bool due_ = false;  // changes that were not handed to the thread

    std::mutex mutex_;
    std::condition_variable wake_;
    std::optional<std::string> text_;  // to be written
    bool stopping_ = false;
    std::thread thread_;
};

ParkedFile::ParkedFile(asio::io_context& io, const std::filesystem::path& stateDirectory,
                       std::chrono::milliseconds pause, ParkedSessions& sessions)
    : file_(stateDirectory / "sessions"), pause_(pause), sessions_(sessions), timer_(io) {
    read();
    thread_ = std::thread([this] { write(); });
}

ParkedFile::~ParkedFile() {
    timer_.cancel();
    if (due_) hand();
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    wake_.notify_one();
    thread_.join();
}

/// Clients that come back know their views themselves: a file that cannot be read is said, and no more.
void ParkedFile::read() {
    const auto text = wire::readPrivateFile(file_, mostParkedBytes);
    if (!text.ok()) {
        if (text.error().code != ErrorCode::notFound) log::warn("{}", text.error().toString());
        return;
    }
    const auto* const bytes = reinterpret_cast<const std::uint8_t*>(text->data());
    const auto added = sessions_.add({bytes, text->size()}, Clock::now());
    if (!added.ok()) log::warn("{}", added.error().within(file_.string()).toString());
}

void ParkedFile::changed() {
    if (std::exchange(due_, true)) return;
    timer_.expires_after(pause_);
    timer_.async_wait([this](const asio::error_code& code) {
        if (!code) hand();
    });
}

void ParkedFile::hand() {
    due_ = false;
    const auto bytes = sessions_.toBytes();
    {
        const std::lock_guard lock(mutex_);
        text_.emplace(bytes.begin(), bytes.end());
    }
    wake_.notify_one();
}

void ParkedFile::write() {
    std::unique_lock lock(mutex_);
    bool failed = false;
    for (;;) {
        wake_.wait(lock, [this] { return stopping_ || text_; });
        if (!text_) return;
        const auto text = *std::exchange(text_, std::nullopt);
        lock.unlock();
        const auto written = wire::writePrivateFile(file_, text);
        // A full disk is said once, not at every view.
        if (!written.ok() && !failed) log::warn("{}", written.error().toString());
        failed = !written.ok();
        lock.lock();
    }
}

}  // namespace

class Server::Impl {
  public:
    Impl(ServerSettings settings, DeviceFactory device)
        : settings_(std::move(settings)), device_(std::move(device)) {}

    ~Impl() {
        withdraw();
        if (jobs_) jobs_->stop();
        if (thumbnails_) thumbnails_->stop();
        render_.reset();
        thumbnails_.reset();
        queries_.reset();
        datasets_.reset();
    }

    Status start() {
        MOTE_ASSIGN_OR_RETURN(auto roots, storage::Roots::parse(settings_.roots));
        MOTE_RETURN_IF_ERROR(checkNotInUse(settings_.connectionFile));
        MOTE_RETURN_IF_ERROR(checkNotInUse(settings_.followerFile));
        jobs_.emplace(io_, jobSettings(settings_));
        MOTE_RETURN_IF_ERROR(jobs_->start([this](const proto::JobStatus& job) { jobChanged(job); }));
        parkedFile_.emplace(io_, settings_.stateDirectory, settings_.parkingPause, parked_);
        const auto memory = dataMemory(settings_.memory);
        if (!memory.ok()) return memory.error().within("memory");
        datasets_ = std::make_unique<DatasetService>(
            std::move(roots), [this] { asio::post(io_, [this] { catalogueChanged(); }); }, *memory,
            [this] { asio::post(io_, [this] { render_->dataArrived(); }); });
        datasets_->rescan();
        queries_ = std::make_unique<QueryService>(*datasets_, datasets_->budget(), queryMemory(*memory),
                                                  queryThreads(processors(settings_)));
        auto render = settings_.render;
        render.memory = std::make_shared<PictureMemory>(pictureMemory(settings_.memory), datasets_->budget());
        render_ = std::make_unique<RenderService>(device_, *datasets_, std::move(render));
        MOTE_ASSIGN_OR_RETURN(const auto name, render_->start());
        thumbnails_ = std::make_unique<Thumbnails>(*datasets_, *render_, settings_.render.crashes,
                                                   settings_.stateDirectory / "thumbnails");
        fillContext(name);
        if (settings_.stopOnSignals) stopOnSignals();
        MOTE_RETURN_IF_ERROR(tellMetrics());
        MOTE_RETURN_IF_ERROR(listen());
        return writeFile();
    }

    void run() {
        if (!ending_) {
            rescanLater();
            entrance_->accept();
        }
        io_.run();
    }

    void stop() {
        asio::post(io_, [this] { end(); });
    }

    void withdraw() {
        removeConnectionFiles(settings_, context_.token, context_.followerToken);
        if (entrance_) entrance_->withdraw();
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
            // In this order: nobody listens to the next signal.
            end();
            log::info("SIG{}: the server ends", ::sigabbrev_np(number));
        });
    }

    void fillContext(const std::string& deviceName) {
        context_.token = settings_.token.empty() ? makeToken() : settings_.token;
        if (!settings_.followerFile.empty()) {
            context_.followerToken = settings_.followerToken.empty() ? makeToken() : settings_.followerToken;
        }
        context_.server = "mote-server " MOTE_VERSION;
        context_.device = deviceName;
        context_.render = render_.get();
        context_.datasets = datasets_.get();
        context_.jobs = &*jobs_;
        context_.queries = queries_.get();
        context_.thumbnails = thumbnails_.get();
        context_.uploads = jobs_->uploads();
        context_.removeUploads = jobs_->remover();
        context_.crashes = settings_.render.crashes;
        context_.parked = &parked_;
        context_.following = &following_;
        context_.silence = settings_.silence;
        context_.idle = settings_.idle;
        context_.staleAfter = settings_.staleAfter;
        context_.closed = [this](SessionId id) {
            following_.leave(id);
            parked_.left(id, Clock::now());
            // Later: the session that says so is in the midst of its own function.
            asio::post(io_, [this, id] {
                sessions_.erase(id);
                if (ending_ && sessions_.empty()) io_.stop();
            });
        };
    }

    Status tellMetrics() {
        if (settings_.metrics.empty()) return success();
        HttpPages pages{[this] { return toPrometheus(*context_.metrics, gauges()); },
                        [this] { return trouble(); }};
        MOTE_ASSIGN_OR_RETURN(http_, HttpListener::open(io_, settings_.metrics, std::move(pages)));
        log::info("metrics at {}", http_->address());
        return success();
    }

    /// Why no client should be sent here. Whether a device that failed draws again only a view can tell: it
    /// gets the next one after a while, so that an idle server does not stay ill for ever.
    std::optional<std::string> trouble() const {
        if (ending_) return "the server ends";
        const auto failed = render_->deviceFailed();
        if (failed && Clock::now() - *failed < settings_.deviceFailureTold)
            return "the device failed at the latest picture";
        return std::nullopt;
    }

    Gauges gauges() const {
        Gauges now;
        now.version = MOTE_VERSION;
        now.device = context_.device;
        now.sessions = sessions_.size();
        now.startups = entrance_->startups();
        now.jobs = jobs_->counts();
        now.datasets = static_cast<std::size_t>(datasets_->catalogue()->datasets_size());
        now.queries = queries_->underWay();
        now.dataBytes = datasets_->budget()->resident();
        now.dataLimit = datasets_->budget()->limit();
        now.healthy = !trouble();
        return now;
    }

    Status listen() {
        HandshakeTerms terms;
        terms.timeout = settings_.handshakeTimeout;
        terms.farewellTimeout = context_.farewellTimeout;
        terms.knows = [this](const std::string& token) { return roleOf(token); };
        terms.room = [this](const proto::Hello& hello) { return room(hello); };
        terms.passed = [this](wire::MessageStream stream, const proto::ClientMessage& hello, Role role) {
            begin(std::move(stream), hello, role);
        };
        entrance_.emplace(io_, settings_, std::move(terms), *context_.metrics);
        return entrance_->open(context_.token);
    }

    /// Both are compared, whichever it is.
    std::optional<Role> roleOf(const std::string& token) const {
        const bool owns = sameToken(context_.token, token);
        const bool follows = sameToken(context_.followerToken, token);
        if (owns) return Role::owner;
        return follows ? std::optional(Role::follower) : std::nullopt;
    }

    Status writeFile() {
        proto::ConnectionFile file;
        file.set_token(context_.token);
        file.set_pid(::getpid());
        file.set_protocol_major(wire::ownVersion.major);
        file.set_protocol_minor(wire::ownVersion.minor);
        entrance_->tellFilms(file);
        MOTE_RETURN_IF_ERROR(wire::writeConnectionFile(filmConnectionFile(settings_.stateDirectory), file));
        entrance_->tellClients(file);
        MOTE_RETURN_IF_ERROR(wire::writeConnectionFile(settings_.connectionFile, file));
        if (settings_.followerFile.empty()) return success();
        file.set_token(context_.followerToken);
        return wire::writeConnectionFile(settings_.followerFile, file);
    }

    /// Who comes back takes the place of the connection before, which may be dead without anybody knowing.
    Status room(const proto::Hello& hello) const {
        const auto before = parked_.sessionOf(hello.resume());
        if (before && sessions_.contains(*before)) return success();
        if (sessions_.size() < settings_.maxSessions) return success();
        context_.metrics->refusedFull.add();
        log::warn("a client was turned away: {} are connected", sessions_.size());
        return Error{ErrorCode::resourceExhausted, "server",
                     "it has as many clients as it takes; close one of them"};
    }

    void begin(wire::MessageStream stream, const proto::ClientMessage& hello, Role role) {
        const SessionId id = ++lastSession_;
        const auto admission = admit(hello.hello(), id, role);
        auto session = std::make_shared<Session>(id, std::move(stream), context_, role);
        sessions_.emplace(id, session);
        session->start(hello, admission);
        datasets_->rescan();
    }

    /// Of those who follow nothing outlives the connection, and nobody follows them.
    ParkedSessions::Admission admit(const proto::Hello& hello, SessionId id, Role role) {
        if (role == Role::follower) return {};
        auto admission = parked_.admit(hello.resume(), id, Clock::now());
        replace(admission.before);
        if (!hello.background()) following_.enter(id, hello.client());
        following_.goOn(admission.before, id);
        return admission;
    }

    void replace(SessionId before) {
        const auto old = sessions_.extract(before);
        if (old.empty()) return;
        old.mapped()->leave({ErrorCode::cancelled, "session", "its client goes on by another connection"});
    }

    void rescanLater() {
        // A slow disk is not kept busy: a twentieth of the time at most.
        rescan_.expires_after(
            std::max<Clock::duration>(settings_.rescanInterval, 20 * datasets_->lookTime()));
        rescan_.async_wait([this](const asio::error_code& code) {
            if (code || ending_) return;
            parked_.sweepUploads(Clock::now());
            if (!sessions_.empty()) datasets_->rescan();
            rescanLater();
        });
    }

    void catalogueChanged() {
        for (const auto& [id, session] : sessions_) session->catalogueChanged();
    }

    void jobChanged(const proto::JobStatus& job) {
        if (job.state() == proto::JobStatus::SUCCEEDED) datasets_->rescan();
        const auto shared = std::make_shared<const proto::JobStatus>(job);
        for (const auto& [id, session] : sessions_) session->jobChanged(shared);
    }

    /// Sessions have a second for their last word; then nothing is left that run() waits for.
    void end() {
        if (std::exchange(ending_, true)) return;
        finish_.expires_after(2 * context_.farewellTimeout);
        finish_.async_wait([this](const asio::error_code&) { io_.stop(); });
        asio::error_code ignored;
        entrance_->close();
        http_.reset();
        if (signals_) signals_->cancel(ignored);
        rescan_.cancel();
        jobs_->stop();
        for (const auto& [id, session] : sessions_) {
            session->leave({ErrorCode::cancelled, "server", "the server ends"});
        }
        if (sessions_.empty()) io_.stop();
    }

    const ServerSettings settings_;
    const DeviceFactory device_;
    asio::io_context io_{1};  // before all that posts to it
    std::optional<asio::signal_set> signals_;
    asio::steady_timer rescan_{io_}, finish_{io_};
    std::optional<JobService> jobs_;
    std::unique_ptr<DatasetService> datasets_;
    std::unique_ptr<QueryService> queries_;
    std::unique_ptr<RenderService> render_;
    std::unique_ptr<Thumbnails> thumbnails_;
    ParkedSessions parked_{settings_.parking, [this] { parkedFile_->changed(); }};
    std::optional<ParkedFile> parkedFile_;
    Following following_;
    SessionContext context_;
    std::unique_ptr<HttpListener> http_;
    std::map<SessionId, std::shared_ptr<Session>> sessions_;
    std::optional<Entrance> entrance_;
    SessionId lastSession_ = 0;
    bool ending_ = false;
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

void removeConnectionFiles(const ServerSettings& settings, const std::string& token,
                           const std::string& followerToken) {
    const auto removeWith = [](const std::filesystem::path& file, const std::string& expected) {
        const auto content = wire::readConnectionFile(file);
        if (expected.empty() || !content.ok() || content->token() != expected) return;
        std::error_code ignored;
        std::filesystem::remove(file, ignored);
    };
    removeWith(settings.connectionFile, token);
    removeWith(filmConnectionFile(settings.stateDirectory), token);
    removeWith(settings.followerFile, followerToken);
}

}  // namespace mote::server
