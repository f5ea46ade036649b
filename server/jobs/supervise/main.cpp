// SPDX-License-Identifier: GPL-3.0-or-later
//
// mote-supervise: runs one job of the server and outlives it. Started by LocalRunner in a session of its own,
// with stdout and stderr in the job's log and descriptor 3 as its gate. It begins when a byte comes through
// the gate (a server that was killed first sends none; in a job of Slurm there is no gate), runs the program
// after "--" in a group of its own with few rights and the job's progress file as descriptor 3, and writes
// "exit CODE" or "signal NUMBER" to DIRECTORY/result by one rename ("timeout SECONDS" where its time was
// over); the code is 75 (EX_TEMPFAIL) where the place is to blame, and it may go well later. SIGTERM is
// handed on to the program; 5 s later follows SIGKILL. What the program has made beside its place it puts
// there, once nothing of the program runs any more.
#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sysexits.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/base/complain.h"
#include "protocol/base/system_error.h"
#include "server/jobs/job_environment.h"
#include "server/jobs/supervise/supervise.h"
#include "storage/files/file_descriptor.h"

namespace mote::server {
namespace {

using storage::FileDescriptor;

constexpr int kGate = 3;      // of this program
constexpr int kProgress = 3;  // of the program that it runs
constexpr int kCannotStart = 127;

/// As waitpid has it: where the place is to blame, the job may be tried again.
int failedBy(const Error& error) {
    return (error.passing ? EX_TEMPFAIL : 1) << 8;
}

/// Adds what every program of this system needs.
void addSystem(Rights& rights, const std::string& program, const std::string& directory) {
    std::error_code code;
    const auto ours = std::filesystem::read_symlink("/proc/self/exe", code).parent_path();  // mpirun is not
    const auto bin = std::filesystem::path(program).parent_path();
    rights.executable.insert(rights.executable.end(), {ours, bin, "/usr", "/lib", "/lib64", "/bin", "/opt"});
    rights.readable.insert(rights.readable.end(),
                           {directory, "/etc", "/proc", "/sys", "/dev/zero", "/dev/random", "/dev/urandom"});
    rights.writable.emplace_back("/dev/null");
    if (!rights.launcher) return;
    rights.readable.emplace_back("/dev");
    rights.writable.emplace_back("/dev/shm");
}

/// 0; or an exit code, and one line in the job's log, where the kernel cannot and nobody allowed that, or
/// memory is short, which is no reason to run a job unconfined.
int giveUpRights(const Order& order) {
    for (const auto limit : {limitResources, limitFiles, limitCalls}) {
        const auto status = limit(order.rights);
        if (status.ok()) continue;
        const auto why = status.error().toString();
        if (status.error().passing) {
            fmt::print(stderr, "{}\n", why);
            return EX_TEMPFAIL;
        }
        if (!order.unconfined) {
            fmt::print(stderr,
                       "jobs cannot be confined on this machine ({}): none is run, unless mote-server is "
                       "started with --allow-unconfined-jobs\n",
                       why);
            return kCannotStart;
        }
        fmt::print(stderr, "mote-supervise: note: this job is not confined ({})\n", why);
    }
    std::fflush(stderr);
    return 0;
}

std::vector<std::string> programEnvironment() {
#ifdef __SANITIZE_ADDRESS__
    setenv("LSAN_OPTIONS", "detect_leaks=0", 1);  // looking for leaks takes ptrace, which is given up
#endif
    auto variables = jobEnvironment();
    variables.emplace_back("HDF5_PLUGIN_PRELOAD=::");  // foreign files choose no code to load
    return variables;
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
    if (order.rights.launcher) dup2(kProgress, STDOUT_FILENO);
    signal(SIGXFSZ, SIG_DFL);
    auto variables = programEnvironment();
    addSystem(order.rights, order.program[0], order.directory);
    if (const int code = giveUpRights(order)) {
        std::fflush(stderr);
        _exit(code);
    }
    sigprocmask(SIG_UNBLOCK, &signals, nullptr);
    execve(order.program[0], order.program.data(), pointersTo(variables).data());
    const auto error = systemError(errno, order.program[0], "cannot be started");
    fmt::print(stderr, "{}\n", error.toString());
    std::fflush(stderr);
    _exit(error.passing ? EX_TEMPFAIL : kCannotStart);
}

/// Where memory is short the child ends: what it would unwind is the supervisor's.
[[noreturn]] void becomeOrEnd(Order& order, int progress, pid_t supervisor, const sigset_t& signals) {
    try {
        become(order, progress, supervisor, signals);
    } catch (const std::exception& failure) {
        complainAtEnd("mote-supervise", failure);
        _exit(EX_TEMPFAIL);
    }
}

/// Where the output is to lie; empty: it cannot be known.
std::string readOutput(const std::string& directory) {
    std::ifstream file(directory + "/output", std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// Of a program that ended well what it made gets its place; its exit code is another where that is not so.
int publish(std::optional<Staging>& staging, int status) {
    if (!staging || status != 0) return status;
    const auto published = staging->publish();
    if (published.ok()) return status;
    fmt::print(stderr, "{}\n", published.error().toString());
    std::fflush(stderr);
    return failedBy(published.error());
}

/// The folder that the program makes its output in, where it makes one.
Status prepareStaging(Order& order, std::optional<Staging>& staging) {
    if (!order.publishes) return success();
    const auto output = readOutput(order.directory);
    if (output.empty()) return Error{ErrorCode::internal, "", "nobody says where the output is to lie"};
    // Two attempts of a job never meet, nor two jobs: its id is the folder's name.
    const auto id = std::filesystem::path(order.directory).filename().string();
    MOTE_ASSIGN_OR_RETURN(auto made, Staging::create(output + ".partial-" + id, output, order.grows));
    order.rights.writable.insert(order.rights.writable.begin(), made.folder());
    staging.emplace(std::move(made));
    return success();
}

int writeResult(const std::string& directory, const std::string& text) {
    const auto draft = directory + "/result.new";
    FileDescriptor file(open(draft.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
    const bool written =
        file.valid() && write(file.get(), text.data(), text.size()) == static_cast<ssize_t>(text.size()) &&
        fsync(file.get()) == 0 && rename(draft.c_str(), (directory + "/result").c_str()) == 0;
    if (written) return 0;
    fmt::print(stderr, "the job's result cannot be written: {}\n", systemMessage(errno));
    return 1;
}

bool gateOpens() {
    char byte = 0;
    ssize_t got = 0;
    while ((got = read(kGate, &byte, 1)) < 0 && errno == EINTR) {
    }
    close(kGate);
    return got == 1;
}

int run(Order order) {
    signal(SIGXFSZ, SIG_IGN);  // a limit of file sizes becomes an error of the write
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGTERM);
    sigaddset(&signals, SIGCHLD);
    sigprocmask(SIG_BLOCK, &signals, nullptr);

    if (order.gate && !gateOpens()) return 0;

    adoptLeftovers();
    std::optional<Staging> staging;
    if (const auto ready = prepareStaging(order, staging); !ready.ok()) {
        fmt::print(stderr, "{}\n", ready.error().toString());
        return writeResult(order.directory, resultOf({failedBy(ready.error()), false}, 0));
    }
    const auto name = order.directory + "/progress";
    const FileDescriptor progress(open(name.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600));
    const pid_t supervisor = getpid();
    const pid_t child = progress.valid() ? fork() : -1;
    if (child == 0) becomeOrEnd(order, progress.get(), supervisor, signals);
    if (child < 0) {
        fmt::print(stderr, "the job cannot be started: {}\n", systemMessage(errno));
        return writeResult(order.directory, resultOf({EX_TEMPFAIL << 8, false}, 0));
    }
    setpgid(child, child);  // as the child does: whoever is first
    auto end = waitForEnd(child, signals, order.timeLimit);
    if (!end.late) end.status = publish(staging, end.status);
    staging.reset();  // before anybody is told that the job has ended
    return writeResult(order.directory, resultOf(end, order.timeLimit));
}

int superviseProgram(int argc, char** argv) {
    auto order = parseOrder(argc, argv);
    if (order) return run(*std::move(order));
    const bool asked = argc == 2 && std::string_view(argv[1]) == "--help";
    std::fputs(orderHelp, asked ? stdout : stderr);
    return asked ? 0 : 2;
}

}  // namespace
}  // namespace mote::server

int main(int argc, char** argv) {
    try {
        return mote::server::superviseProgram(argc, argv);
    } catch (const std::exception& failure) {
        // Without a result the job was interrupted: it is queued again.
        mote::complainAtEnd("mote-supervise", failure);
        return EX_TEMPFAIL;
    }
}
