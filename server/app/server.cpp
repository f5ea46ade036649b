// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/server.h"

#include <fmt/format.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <asio/io_context.hpp>
#include <asio/local/stream_protocol.hpp>
#include <asio/post.hpp>
#include <asio/signal_set.hpp>
#include <asio/steady_timer.hpp>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <map>
#include <optional>
#include <thread>

#include "protocol/scene/system_error.h"
#include "protocol/wire/address.h"
#include "protocol/wire/connection_file.h"
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
    jobs.frames = settings.frames;
    jobs.roots = settings.roots;
    jobs.memory = settings.memory;
    jobs.threads = settings.threads;
    return jobs;
}

namespace fs = std::filesystem;

constexpr const char* socketName = "mote.sock";

Status removeStale(const fs::path& path) {
    struct stat status {};
    if (::lstat(path.c_str(), &status) != 0) {
        if (errno == ENOENT) return success();
        return Error{ErrorCode::permissionDenied, path.string(), systemMessage(errno)};
    }
    if (!S_ISSOCK(status.st_mode)) {
        return Error{ErrorCode::alreadyExists, path.string(),
                     "is no socket but stands where the server's socket belongs; move it away"};
    }
    if (::unlink(path.c_str()) == 0) return success();
    return Error{ErrorCode::permissionDenied, path.string(), systemMessage(errno)};
}

/// XDG_RUNTIME_DIR, the user's alone and short on every system that has it; else the folder for temporary
/// files.
fs::path runtimeFolder() {
    const char* folder = ::secure_getenv("XDG_RUNTIME_DIR");
    if (folder && *folder == '/' && ::access(folder, W_OK) == 0) return folder;
    std::error_code code;
    const auto temporary = fs::temp_directory_path(code);
    return code ? fs::path("/tmp") : temporary;
}

/// Where the Unix socket lies. In the state directory, which belongs to one server at a time (its job queue
/// holds the lock), so that a socket found there is a dead server's; in a fresh private folder where the
/// state directory's path is too long for the kernel. Removed with the object.
class SocketPlace {
  public:
    /// Removes a stale socket. Call once the state directory's lock is held. Errors: alreadyExists (something
    /// that is no socket has its name), invalidArgument (no place has a path that is short enough),
    /// permissionDenied, internal.
    static Result<SocketPlace> make(const fs::path& stateDirectory);

    SocketPlace(SocketPlace&& other) noexcept
        : path_(std::exchange(other.path_, {})), folder_(std::exchange(other.folder_, {})) {}
    SocketPlace& operator=(SocketPlace&&) = delete;
    ~SocketPlace() {
        if (path_.empty()) return;
        ::unlink(path_.c_str());
        if (!folder_.empty()) ::rmdir(folder_.c_str());
    }

    const fs::path& path() const { return path_; }

  private:
    SocketPlace(fs::path path, fs::path folder) : path_(std::move(path)), folder_(std::move(folder)) {}

    fs::path path_;
    fs::path folder_;  // of our own, to be removed; or empty
};

Result<SocketPlace> SocketPlace::make(const fs::path& stateDirectory) {
    std::error_code code;
    const fs::path wanted = fs::absolute(stateDirectory, code) / socketName;
    if (wanted.native().size() <= wire::maxSocketPath) {
        MOTE_RETURN_IF_ERROR(removeStale(wanted));
        return SocketPlace(wanted, {});
    }
    std::string folder = (runtimeFolder() / "mote-XXXXXX").string();
    if (folder.size() + 1 + std::strlen(socketName) > wire::maxSocketPath) {
        return Error{ErrorCode::invalidArgument, wanted.string(),
                     fmt::format("a socket's path has at most {} bytes; give --state a shorter one",
                                 wire::maxSocketPath)};
    }
    if (!::mkdtemp(folder.data())) {
        return Error{ErrorCode::internal, folder, fmt::format("cannot be made: {}", systemMessage(errno))};
    }
    return SocketPlace(fs::path(folder) / socketName, folder);
}

// A server that was just killed accepts until the kernel has taken it apart.
constexpr int attempts = 50;
constexpr std::chrono::milliseconds pause{10};

/// Whether somebody accepts connections there.
bool alive(const std::string& address) {
    const auto parsed = wire::parseAddress(address);
    if (!parsed.ok() || parsed->kind != wire::Address::Kind::unixSocket) return false;
    asio::io_context context;
    Protocol::socket socket(context);
    asio::error_code code;
    socket.connect(Protocol::endpoint(parsed->path), code);
    return !code;
}

/// A server takes no live one's connection file. Errors: alreadyExists, where the file belongs to a server
/// that accepts connections now.
Status checkNotInUse(const std::filesystem::path& file) {
    const auto old = wire::readConnectionFile(file);
    if (!old.ok()) return success();
    for (int attempt = 0; attempt < attempts; ++attempt) {
        if (!alive(old->address())) return success();
        std::this_thread::sleep_for(pause);
    }
    return Error{ErrorCode::alreadyExists, file.string(),
                 fmt::format("belongs to a server that runs (process {}); stop it or give --connection "
                             "another file",
                             old->pid())};
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
        removeConnectionFiles(settings_, context_.token);
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
        MOTE_RETURN_IF_ERROR(wire::writeConnectionFile(filmConnectionFile(settings_.stateDirectory), file));
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

void removeConnectionFiles(const ServerSettings& settings, const std::string& token) {
    for (const auto& file : {settings.connectionFile, filmConnectionFile(settings.stateDirectory)}) {
        const auto content = wire::readConnectionFile(file);
        if (token.empty() || !content.ok() || content->token() != token) continue;
        std::error_code ignored;
        std::filesystem::remove(file, ignored);
    }
}

}  // namespace mote::server
