// SPDX-License-Identifier: GPL-3.0-or-later
//
// mote-supervise: runs one job of the server and outlives it. Started by LocalRunner in a session of its own,
// with stdout and stderr in the job's log and descriptor 3 as its gate. It begins when a byte comes through
// the gate (a server that was killed first sends none), runs the program after "--" in a group of its own
// with few rights and the job's progress file as descriptor 3, and writes "exit CODE" or "signal NUMBER" to
// DIRECTORY/result by one rename. SIGTERM is handed on to the program; 5 s later follows SIGKILL.
#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/scene/system_error.h"
#include "server/jobs/supervise/rights.h"
#include "storage/files/file_descriptor.h"

namespace mote::server {
namespace {

using storage::FileDescriptor;

using Clock = std::chrono::steady_clock;

constexpr int kGate = 3;      // of this program
constexpr int kProgress = 3;  // of the program that it runs
constexpr std::chrono::seconds kPatience(5);
constexpr int kCannotStart = 127;

constexpr const char* help =
    R"(Runs one job of mote-server, with few rights, and outlives the server that started it.
Usage: mote-supervise --directory DIR [OPTIONS] -- PROGRAM [ARGUMENT]...

Options:
  --help                      Print this help message and exit
  --directory DIR REQUIRED    The job's folder, for its progress and its result
  --memory BYTES              What the program may take
  --nice STEPS                How far its priority lies below this program's
  --sockets unix              It may open Unix sockets, and no others
  --read DIR ...              What the program may read besides the system
  --write DIR ...             What it may write
)";

struct Order {
    std::string directory;
    Rights rights;
    std::vector<char*> program;  ///< and its arguments, a null pointer last
};

std::optional<Order> parse(int argc, char** argv) {
    Order order;
    int i = 1;
    for (; i + 1 < argc && std::string_view(argv[i]) != "--"; i += 2) {
        const std::string_view option(argv[i]), value(argv[i + 1]);
        if (option == "--directory") {
            order.directory = value;
        } else if (option == "--read") {
            order.rights.readable.emplace_back(value);
        } else if (option == "--write") {
            order.rights.writable.emplace_back(value);
        } else if (option == "--memory") {
            std::from_chars(value.data(), value.data() + value.size(), order.rights.memory);
        } else if (option == "--nice") {
            std::from_chars(value.data(), value.data() + value.size(), order.rights.niceness);
        } else if (option == "--sockets" && value == "unix") {
            order.rights.unixSockets = true;
        } else {
            return std::nullopt;
        }
    }
    if (order.directory.empty() || i + 1 >= argc) return std::nullopt;
    order.program.assign(argv + i + 1, argv + argc);
    order.program.push_back(nullptr);
    return order;
}

/// Adds what every program of this system needs.
void addSystem(Rights& rights, const std::string& program, const std::string& directory) {
    const auto bin = std::filesystem::path(program).parent_path();
    rights.executable.insert(rights.executable.end(), {bin, "/usr", "/lib", "/lib64", "/bin", "/opt"});
    rights.readable.insert(rights.readable.end(), {directory, "/etc", "/proc", "/sys", "/dev"});
    rights.writable.insert(rights.writable.end(), {"/dev/null", "/dev/shm"});
}

/// Best effort: what a kernel does not have is said in the job's log.
void giveUpRights(const Rights& rights) {
    for (const auto& status : {limitResources(rights), limitFiles(rights), limitCalls(rights)}) {
        if (!status.ok()) fmt::print(stderr, "mote-supervise: note: {}\n", status.error().toString());
    }
    std::fflush(stderr);
}

/// Runs in the child, before anything else of the program.
[[noreturn]] void become(Order& order, int progress, pid_t supervisor, const sigset_t& signals) {
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // an unsupervised program could never be found again
    if (getppid() != supervisor) _exit(kCannotStart);
    if (progress == kProgress) {
        fcntl(progress, F_SETFD, 0);
    } else {
        dup2(progress, kProgress);
    }
    closefrom(kProgress + 1);
    signal(SIGXFSZ, SIG_DFL);
    setenv("HDF5_PLUGIN_PRELOAD", "::", 1);  // foreign files choose no code to load
#ifdef __SANITIZE_ADDRESS__
    setenv("LSAN_OPTIONS", "detect_leaks=0", 1);  // looking for leaks takes ptrace, which is given up
#endif
    addSystem(order.rights, order.program[0], order.directory);
    giveUpRights(order.rights);
    sigprocmask(SIG_UNBLOCK, &signals, nullptr);
    execv(order.program[0], order.program.data());
    fmt::print(stderr, "{} cannot be started: {}\n", order.program[0], systemMessage(errno));
    std::fflush(stderr);
    _exit(kCannotStart);
}

/// Waits for the child's end, hands SIGTERM on and sees to it that it is obeyed.
int superviseChild(pid_t child, const sigset_t& signals) {
    std::optional<Clock::time_point> killAt;
    while (true) {
        siginfo_t info{};
        waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOHANG | WNOWAIT);
        if (info.si_pid == child) break;
        if (!killAt) {
            if (sigwaitinfo(&signals, nullptr) == SIGTERM) {
                kill(-child, SIGTERM);
                killAt = Clock::now() + kPatience;
            }
            continue;
        }
        const auto left = *killAt - Clock::now();
        if (left <= Clock::duration::zero()) {
            kill(-child, SIGKILL);
            killAt = Clock::now() + kPatience;
            continue;
        }
        const auto nanoseconds = std::chrono::duration_cast<std::chrono::nanoseconds>(left).count();
        const timespec wait{nanoseconds / 1'000'000'000, nanoseconds % 1'000'000'000};
        sigtimedwait(&signals, nullptr, &wait);
    }
    kill(-child, SIGKILL);  // what it left behind; its number is its own until it is waited for
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    return status;
}

int writeResult(const std::string& directory, int status) {
    const auto text = WIFSIGNALED(status) ? fmt::format("signal {}\n", WTERMSIG(status))
                                          : fmt::format("exit {}\n", WEXITSTATUS(status));
    const auto draft = directory + "/result.new";
    FileDescriptor file(open(draft.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
    const bool written =
        file.valid() && write(file.get(), text.data(), text.size()) == static_cast<ssize_t>(text.size()) &&
        fsync(file.get()) == 0 && rename(draft.c_str(), (directory + "/result").c_str()) == 0;
    if (written) return 0;
    fmt::print(stderr, "the job's result cannot be written: {}\n", systemMessage(errno));
    return 1;
}

int run(Order order) {
    signal(SIGXFSZ, SIG_IGN);  // a limit of file sizes becomes an error of the write
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGTERM);
    sigaddset(&signals, SIGCHLD);
    sigprocmask(SIG_BLOCK, &signals, nullptr);

    char byte = 0;
    ssize_t got = 0;
    while ((got = read(kGate, &byte, 1)) < 0 && errno == EINTR) {
    }
    if (got != 1) return 0;
    close(kGate);

    const auto name = order.directory + "/progress";
    const FileDescriptor progress(open(name.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600));
    const pid_t supervisor = getpid();
    const pid_t child = progress.valid() ? fork() : -1;
    if (child == 0) become(order, progress.get(), supervisor, signals);
    if (child < 0) {
        fmt::print(stderr, "the job cannot be started: {}\n", systemMessage(errno));
        return writeResult(order.directory, kCannotStart << 8);
    }
    setpgid(child, child);  // as the child does: whoever is first
    return writeResult(order.directory, superviseChild(child, signals));
}

}  // namespace
}  // namespace mote::server

int main(int argc, char** argv) {
    auto order = mote::server::parse(argc, argv);
    if (!order) {
        const bool asked = argc == 2 && std::string_view(argv[1]) == "--help";
        fmt::print(asked ? stdout : stderr, mote::server::help);
        return asked ? 0 : 2;
    }
    return mote::server::run(*std::move(order));
}
