// SPDX-License-Identifier: GPL-3.0-or-later
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <asio/io_context.hpp>
#include <asio/posix/stream_descriptor.hpp>
#include <cerrno>
#include <system_error>

#include "protocol/base/system_error.h"
#include "server/jobs/job_environment.h"
#include "server/jobs/process_identity.h"
#include "server/jobs/runner.h"
#include "storage/files/file_descriptor.h"

namespace mote::server {
namespace {

using storage::FileDescriptor;

constexpr const char* localPrefix = "local ";  // of handles
constexpr int kGate = 3;                       // the supervisor's descriptor of it

class LocalRun final : public Run {
  public:
    LocalRun(asio::io_context& context, ProcessIdentity identity, FileDescriptor gate)
        : identity_(std::move(identity)), process_(context), gate_(std::move(gate)) {}

    /// Once, before all else. Errors: resourceExhausted, internal.
    Status watch(FileDescriptor process) {
        std::error_code code;
        process_.assign(process.get(), code);
        if (code) return systemError(code.value(), "", "the job's process cannot be watched");
        process.release();
        return success();
    }

    std::string handle() const override { return localPrefix + identity_.toString(); }
    std::string id() const override { return std::to_string(identity_.pid); }

    void go() override {
        // No SIGPIPE from a supervisor that has ended: onEnd tells of it.
        const char byte = 'g';
        if (gate_.valid() && ::send(gate_.get(), &byte, 1, MSG_NOSIGNAL) != 1) {
        }
        gate_ = {};
    }

    void onEnd(std::function<void(RunEnd)> ended) override {
        process_.async_wait(asio::posix::stream_descriptor::wait_read,
                            [this, ended = std::move(ended)](const std::error_code& code) {
                                if (code == asio::error::operation_aborted) return;
                                reap();
                                ended({});
                            });
    }

    void cancel() override {
        // The signal goes through the pidfd: never to a stranger who has the number by now.
        syscall(SYS_pidfd_send_signal, process_.native_handle(), SIGTERM, nullptr, 0);
    }

  private:
    /// Takes the ended process from the kernel if it is a child of this server, and not of an earlier one.
    void reap() {
        siginfo_t info{};
        waitid(static_cast<idtype_t>(P_PIDFD), static_cast<id_t>(process_.native_handle()), &info,
               WEXITED | WNOHANG);
    }

    ProcessIdentity identity_;
    asio::posix::stream_descriptor process_;  // a pidfd: readable when the process has ended
    FileDescriptor gate_;
};

/// posix_spawn with a session of its own, its output in the job's log and the gate at kGate; 0 or an errno.
int spawn(std::vector<std::string> words, const std::string& log, int gate, pid_t& pid) {
    const auto argv = pointersTo(words);
    auto variables = jobEnvironment();
    const auto pointers = pointersTo(variables);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    // Each takes memory, and without any one of them another program would be run.
    int error = posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
    if (error == 0)
        error = posix_spawn_file_actions_addopen(&files, 1, log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
    if (error == 0) error = posix_spawn_file_actions_adddup2(&files, 1, 2);
    if (error == 0) error = posix_spawn_file_actions_adddup2(&files, gate, kGate);
    if (error == 0) error = posix_spawn_file_actions_addclosefrom_np(&files, kGate + 1);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t all, none;
    sigfillset(&all);
    sigemptyset(&none);
    posix_spawnattr_setsigdefault(&attributes, &all);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setflags(&attributes,
                             POSIX_SPAWN_SETSID | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK);
    if (error == 0) error = posix_spawn(&pid, argv[0], &files, &attributes, argv.data(), pointers.data());
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    return error;
}

Result<std::unique_ptr<Run>> watch(asio::io_context& context, const ProcessIdentity& identity,
                                   FileDescriptor process, FileDescriptor gate = {}) {
    auto run = std::make_unique<LocalRun>(context, identity, std::move(gate));
    MOTE_RETURN_IF_ERROR(run->watch(std::move(process)));
    return std::unique_ptr<Run>(std::move(run));
}

/// Of a child that is not waited for: nobody else gets its number meanwhile.
Result<std::unique_ptr<Run>> watchChild(asio::io_context& context, pid_t child, FileDescriptor gate) {
    MOTE_ASSIGN_OR_RETURN(const auto identity, ProcessIdentity::of(child));
    FileDescriptor process(static_cast<int>(syscall(SYS_pidfd_open, child, 0)));
    if (!process.valid()) return systemError(errno, "", "the job's process cannot be watched");
    return watch(context, identity, std::move(process), std::move(gate));
}

class LocalRunner final : public Runner {
  public:
    LocalRunner(asio::io_context& context, std::filesystem::path supervisor)
        : context_(context), supervisor_(std::move(supervisor)) {}

    void start(const RunOrder& order, Started started) override { started(spawned(order)); }
    Result<std::unique_ptr<Run>> find(std::string_view handle) override;

  private:
    Result<std::unique_ptr<Run>> spawned(const RunOrder& order);

    asio::io_context& context_;
    std::filesystem::path supervisor_;
};

Result<std::unique_ptr<Run>> LocalRunner::spawned(const RunOrder& order) {
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
        return systemError(errno, "", "the job cannot be started");
    }
    FileDescriptor gate(ends[0]);
    const FileDescriptor theirs(ends[1]);
    pid_t pid = 0;
    const auto words = supervisorArguments(order, supervisor_.string());
    const int error = spawn(words, (order.directory / "log").string(), theirs.get(), pid);
    if (error != 0) return systemError(error, supervisor_.string(), "cannot be started");
    auto run = watchChild(context_, pid, std::move(gate));
    // Without its gate it ends by itself.
    if (!run.ok()) waitpid(pid, nullptr, 0);
    return run;
}

Result<std::unique_ptr<Run>> LocalRunner::find(std::string_view handle) {
    if (!handle.starts_with(localPrefix)) return std::unique_ptr<Run>();
    const auto identity = ProcessIdentity::parse(handle.substr(std::string_view(localPrefix).size()));
    if (!identity) return std::unique_ptr<Run>();
    auto process = identity->open();
    if (!process.ok() && process.error().code == ErrorCode::notFound) return std::unique_ptr<Run>();
    MOTE_RETURN_IF_ERROR(process);
    pollfd end{process->get(), POLLIN, 0};
    if (poll(&end, 1, 0) == 1) return std::unique_ptr<Run>();  // ended, and not waited for yet
    return watch(context_, *identity, *std::move(process));
}

}  // namespace

std::vector<std::string> supervisorArguments(const RunOrder& order, const std::string& supervisor) {
    std::vector<std::string> words{supervisor,
                                   "--directory",
                                   order.directory.string(),
                                   "--memory",
                                   std::to_string(order.memory),
                                   "--nice",
                                   std::to_string(order.niceness)};
    if (!order.writable.empty()) words.insert(words.end(), {"--write", order.writable.string()});
    for (const auto& folder : order.readable) words.insert(words.end(), {"--read", folder.string()});
    if (order.unixSockets) words.insert(words.end(), {"--sockets", "unix"});
    if (order.publishes) words.insert(words.end(), {"--publish", order.grows ? "steps" : "output"});
    if (order.unconfined) words.insert(words.end(), {"--unconfined", "allowed"});
    if (!order.scratch.empty()) words.insert(words.end(), {"--write", order.scratch.string()});
    if (order.launcher) words.insert(words.end(), {"--launcher", "mpi"});
    if (order.timeLimit > 0) words.insert(words.end(), {"--time-limit", std::to_string(order.timeLimit)});
    if (order.fileSize > 0) words.insert(words.end(), {"--file-size", std::to_string(order.fileSize)});
    words.emplace_back("--");
    words.insert(words.end(), order.program.begin(), order.program.end());
    return words;
}

std::unique_ptr<Runner> makeLocalRunner(asio::io_context& context, std::filesystem::path supervisor) {
    return std::make_unique<LocalRunner>(context, std::move(supervisor));
}

}  // namespace mote::server
