// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/server_line.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>
#include <array>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <string>
#include <system_error>
#include <utility>

#include "protocol/base/system_error.h"

namespace mote::client {
namespace {

// A software rasteriser compiles its shaders before it is ready; minutes mean that it hangs.
constexpr int readyTimeoutMs = 120'000;
// The server promises to end within 10 s.
constexpr int endTimeoutMs = 15'000;

Error internalError(std::string_view what, int number) {
    return {ErrorCode::internal, "mote-server", fmt::format("{}: {}", what, systemMessage(number))};
}

std::vector<std::string> commandLine(const ServerCommand& command, const std::filesystem::path& folder,
                                     const std::filesystem::path& connection) {
    std::vector<std::string> words{command.program.string()};
    for (const auto& root : command.roots) words.insert(words.end(), {"--root", root});
    words.insert(words.end(), {"--state", (folder / "state").string(), "--connection", connection.string()});
    if (command.device) words.insert(words.end(), {"--device", *command.device});
    if (command.threads > 0) words.insert(words.end(), {"--threads", std::to_string(command.threads)});
    return words;
}

/// Runs between fork and exec: only what is safe there.
[[noreturn]] void becomeServer(std::vector<char*>& words, int output, int log, const Interrupt& interrupt) {
    interrupt.restoreInChild();
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    const int nothing = ::open("/dev/null", O_RDONLY);
    ::dup2(nothing, STDIN_FILENO);
    ::dup2(output, STDOUT_FILENO);
    ::dup2(log, STDERR_FILENO);
    ::execv(words.front(), words.data());
    static constexpr char sentence[] = "mote-server cannot be executed\n";
    [[maybe_unused]] const auto ignored = ::write(STDERR_FILENO, sentence, sizeof(sentence) - 1);
    ::_exit(127);
}

// What is younger may belong to a program that does not hold its log.
constexpr std::chrono::hours leftBehind{24};
constexpr int mostLooked = 100'000;

/// Whether nobody holds the log of a private server's folder any more.
bool isLeftBehind(const std::filesystem::path& folder) {
    struct stat found {};
    if (::lstat(folder.c_str(), &found) != 0 || !S_ISDIR(found.st_mode) || found.st_uid != ::geteuid())
        return false;
    const int log = ::open((folder / "log").c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC);
    if (log < 0) return false;
    const bool held = ::flock(log, LOCK_EX | LOCK_NB) != 0;
    const bool known = ::fstat(log, &found) == 0;
    ::close(log);
    const auto written = std::chrono::system_clock::from_time_t(found.st_mtime);
    return known && !held && std::chrono::system_clock::now() - written > leftBehind;
}

/// Removes the folders of servers whose owners were killed.
void removeLeftBehind(std::string_view owner) {
    std::error_code code;
    std::vector<std::filesystem::path> gone;
    std::filesystem::directory_iterator entry(std::filesystem::temp_directory_path(code), code);
    for (int looked = 0; !code && entry != std::filesystem::directory_iterator() && looked < mostLooked;
         ++looked) {
        const auto name = entry->path().filename().string();
        const bool named =
            name.size() == owner.size() + 7 && name.starts_with(owner) && name[owner.size()] == '-';
        if (named && isLeftBehind(entry->path())) gone.push_back(entry->path());
        entry.increment(code);
    }
    for (const auto& folder : gone) std::filesystem::remove_all(folder, code);
}

/// Waits for any of them; false after the timeout.
bool waitFor(std::array<pollfd, 2>& descriptors, int timeoutMs) {
    int count = -1;
    do {
        count = ::poll(descriptors.data(), descriptors.size(), timeoutMs);
    } while (count < 0 && errno == EINTR);
    return count > 0;
}

}  // namespace

std::filesystem::path serverBesideUs() {
    std::error_code code;
    return std::filesystem::read_symlink("/proc/self/exe", code).parent_path() / "mote-server";
}

Result<std::unique_ptr<PrivateServer>> PrivateServer::start(std::string_view owner,
                                                            const ServerCommand& command,
                                                            const Interrupt& interrupt) {
    MOTE_ASSIGN_OR_RETURN(auto server, launch(owner, command, interrupt));
    MOTE_RETURN_IF_ERROR(server->waitUntilReady(interrupt));
    return server;
}

Result<std::unique_ptr<PrivateServer>> PrivateServer::launch(std::string_view owner,
                                                             const ServerCommand& command,
                                                             const Interrupt& interrupt) {
    if (::access(command.program.c_str(), X_OK) != 0) {
        return Error{ErrorCode::notFound, command.program.string(), "there is no server to start here"};
    }
    removeLeftBehind(owner);
    std::unique_ptr<PrivateServer> server(new PrivateServer(owner));
    MOTE_RETURN_IF_ERROR(server->execute(command, interrupt));
    return server;
}

Status PrivateServer::execute(const ServerCommand& command, const Interrupt& interrupt) {
    std::error_code code;
    std::filesystem::create_directory(folder_.path() / "state", code);
    auto texts = commandLine(command, folder_.path(), connectionFile());
    std::vector<char*> words;
    words.reserve(texts.size() + 1);
    for (auto& text : texts) words.push_back(text.data());
    words.push_back(nullptr);
    std::array<int, 2> pipe{};
    if (::pipe2(pipe.data(), O_CLOEXEC) != 0) return internalError("no pipe", errno);
    output_ = pipe[0];
    log_ = ::open(logFile().c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    // Held for as long as one of us lives: removeLeftBehind().
    if (log_ >= 0) ::flock(log_, LOCK_EX | LOCK_NB);
    child_ = log_ < 0 ? -1 : ::fork();
    const int failure = errno;
    if (child_ == 0) becomeServer(words, pipe[1], log_, interrupt);
    ::close(pipe[1]);
    if (child_ < 0) return internalError("cannot be started", failure);
    process_ = static_cast<int>(::syscall(SYS_pidfd_open, child_, 0));  // glibc 2.36's header is not for C++
    if (process_ < 0) return internalError("cannot be watched", errno);
    return success();
}

Status PrivateServer::waitUntilReady(const Interrupt& interrupt) {
    std::string said;
    std::array<char, 512> buffer{};
    // The line is short; a server that says more than this first is not ours.
    while (said.size() < 4096) {
        std::array<pollfd, 2> descriptors{pollfd{output_, POLLIN, 0},
                                          pollfd{interrupt.descriptor(), POLLIN, 0}};
        if (!waitFor(descriptors, readyTimeoutMs)) {
            return Error{ErrorCode::internal, "mote-server", "did not become ready in time"};
        }
        if (interrupt.requested()) return Error{ErrorCode::cancelled, "", "interrupted"};
        const auto count = ::read(output_, buffer.data(), buffer.size());
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return died();
        said.append(buffer.data(), static_cast<std::size_t>(count));
        const bool ready = said.compare(0, 5, "ready") == 0 || said.find("\nready") != std::string::npos;
        if (ready && said.back() == '\n') return success();
    }
    return Error{ErrorCode::internal, "mote-server", "did not say that it is ready"};
}

Error PrivateServer::died() const {
    const auto words = lastWords();
    return {ErrorCode::internal, "mote-server",
            words.empty() ? "ended before it was ready and gave no reason"
                          : "ended before it was ready: " + words};
}

std::string PrivateServer::lastWords() const {
    std::ifstream log(logFile());
    std::string line, last;
    while (std::getline(log, line)) {
        if (!line.empty()) last = line;
    }
    return last;
}

PrivateServer::~PrivateServer() {
    if (child_ > 0) {
        ::kill(child_, SIGTERM);
        pollfd ended{process_, POLLIN, 0};
        int count = -1;
        do {
            count = ::poll(&ended, 1, process_ < 0 ? 0 : endTimeoutMs);
        } while (count < 0 && errno == EINTR);
        if (count <= 0) ::kill(-child_, SIGKILL);
        while (::waitpid(child_, nullptr, 0) < 0 && errno == EINTR) {
        }
    }
    if (process_ >= 0) ::close(process_);
    if (output_ >= 0) ::close(output_);
    if (log_ >= 0) ::close(log_);
}

TemporaryFolder::TemporaryFolder(std::string_view prefix) {
    std::string name = (std::filesystem::temp_directory_path() / prefix).string() + "-XXXXXX";
    if (::mkdtemp(name.data()) == nullptr) {
        throw std::system_error(errno, std::generic_category(), "a folder like " + name + " cannot be made");
    }
    path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

namespace {

/// A server of a node that is down for the night is still waited for.
constexpr std::chrono::hours untiringPatience{24 * 30};
/// A server that does not answer is not told goodbye for longer.
constexpr std::chrono::milliseconds farewellPatience{200}, farewellPause{10};

}  // namespace

Result<std::unique_ptr<ServerLine>> ServerLine::open(const std::string& program, const ServerChoice& choice,
                                                     Wakeup& wakeup, const Interrupt& interrupt) {
    std::unique_ptr<ServerLine> server(new ServerLine(interrupt, wakeup));
    if (!choice.connect) {
        MOTE_ASSIGN_OR_RETURN(server->server_, PrivateServer::start(program, choice.spawn, interrupt));
    }
    ConnectionSettings settings;
    settings.client = program + " " MOTE_VERSION;
    settings.wake = [&wakeup] { wakeup(); };
    settings.background = choice.background;
    server->waitsWhile_ = choice.waitsWhile;
    if (!choice.waitsWhile.empty()) settings.returnPatience = untiringPatience;
    const auto file = server->server_ ? server->server_->connectionFile() : *choice.connect;
    server->line_ = std::make_unique<Connection>(file, settings);
    return server;
}

Status ServerLine::waitUntil(const std::function<bool()>& done) {
    while (true) {
        line_->poll();
        if (interrupt_.requested()) return Error{ErrorCode::cancelled, "", "interrupted"};
        if (done()) return success();
        if (const auto reason = lost()) return *reason;
        wakeup_.wait(signalPatience);
    }
}

Status ServerLine::waitUntilConnected() {
    return waitUntil([&] { return line_->state() == Connection::State::connected; });
}

void ServerLine::farewell() {
    // Messages are read in their order: who answers a ping has heard all before it.
    const auto heard = std::make_shared<bool>(false);
    line_->ping([heard](const Result<double>&) { *heard = true; });
    const auto end = std::chrono::steady_clock::now() + farewellPatience;
    while (!*heard && std::chrono::steady_clock::now() < end) {
        line_->poll();
        if (!*heard) wakeup_.wait(farewellPause);
    }
}

std::optional<Error> ServerLine::lost() const {
    if (givenUp_) return givenUp_;
    std::error_code code;
    if (!waitsWhile_.empty() && line_->state() == Connection::State::connecting &&
        !std::filesystem::exists(waitsWhile_, code))
        return Error{ErrorCode::notFound, waitsWhile_.string(), "is gone, and the server with it"};
    if (line_->state() != Connection::State::lost) return std::nullopt;
    const auto reason = line_->lostReason().value_or(Error{});
    if (!server_ || server_->lastWords().empty()) return reason;
    return Error{reason.code, "mote-server",
                 fmt::format("{}; it last said: {}", reason.toString(), server_->lastWords())};
}

}  // namespace mote::client
