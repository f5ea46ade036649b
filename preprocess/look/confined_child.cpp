// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/look/confined_child.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/landlock.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>

#include "protocol/base/complain.h"
#include "protocol/base/system_error.h"

namespace mote::prep {
namespace {

constexpr std::uint64_t headroom = std::uint64_t{1} << 29;  // libraries, stacks of threads
constexpr int askedEach = 100;                              // ms, whether a signal came
constexpr int patience = 20;                                // times that, after which the child is killed
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool limitsMemory = false;  // their shadow counts
#else
constexpr bool limitsMemory = true;
#endif

void lower(int resource, std::uint64_t value) {
    const auto which = static_cast<__rlimit_resource_t>(resource);
    rlimit limit{};
    if (::getrlimit(which, &limit) != 0) return;
    limit.rlim_cur = limit.rlim_max = std::min<rlim_t>(value, limit.rlim_max);
    ::setrlimit(which, &limit);
}

/// Takes away every right over files that the first version of Landlock knows, but to read them. Kernels
/// without it refuse, and there is nothing to be done then.
void writeNothing() {
    landlock_ruleset_attr rules{};
    rules.handled_access_fs = ((std::uint64_t{1} << 13) - 1) &
                              ~std::uint64_t{LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR};
    const auto made = static_cast<int>(::syscall(SYS_landlock_create_ruleset, &rules, sizeof rules, 0));
    if (made < 0) return;
    ::syscall(SYS_landlock_restrict_self, made, 0);
    ::close(made);
}

void confine(const Confinement& confinement, pid_t parent) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(1);  // it ended before that
    ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    lower(RLIMIT_CORE, 0);
    if (limitsMemory) lower(RLIMIT_DATA, memoryFor(confinement.memory) + headroom);
    if (confinement.seconds > 0) lower(RLIMIT_CPU, confinement.seconds);
    writeNothing();
}

/// Waits until the child has ended, which is when nobody holds the other end of `alive` any more. Passes on
/// the signals of this process.
void waitFor(pid_t child, int alive, const CancelSignal& signal) {
    pollfd waited{alive, POLLIN, 0};
    for (int told = 0; ::poll(&waited, 1, askedEach) <= 0;) {
        if (signal.received() == 0) continue;
        if (told == 0) ::kill(child, signal.received());
        if (told++ == patience) ::kill(child, SIGKILL);
    }
}

Result<int> endOf(int status, const Confinement& confinement, const CancelSignal& signal) {
    if (WIFEXITED(status)) return WEXITSTATUS(status);
    if (signal.received() != 0) return wasCancelled();
    const int number = WTERMSIG(status);
    if (confinement.seconds > 0 && (number == SIGXCPU || number == SIGKILL)) {
        return Error{
            ErrorCode::resourceExhausted, "",
            fmt::format("reading it took more than {} s of the processor or more memory than there is",
                        confinement.seconds)};
    }
    return corrupt("",
                   fmt::format("is damaged in a way that its reader does not survive (it was ended by signal "
                               "{}: {})",
                               number, ::strsignal(number)));
}

/// The child ends here: an exception that went on would make a second one of whoever called.
[[noreturn]] void runAndEnd(const std::function<int()>& work) {
    int status = 1;
    try {
        status = work();
        std::fflush(nullptr);
    } catch (const std::exception& failure) {
        complainAtEnd("mote-prep", failure);
    }
    ::_exit(status);
}

}  // namespace

Result<int> runConfined(const std::function<int()>& work, const Confinement& confinement,
                        const CancelSignal& signal) {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) return systemError(errno, "", "a child process cannot be made");
    std::fflush(nullptr);
    const pid_t parent = ::getpid();
    const pid_t child = ::fork();
    if (child == 0) {
        ::close(ends[0]);
        confine(confinement, parent);
        runAndEnd(work);
    }
    ::close(ends[1]);
    if (child < 0) {
        ::close(ends[0]);
        return systemError(errno, "", "a child process cannot be made");
    }
    waitFor(child, ends[0], signal);
    ::close(ends[0]);
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    return endOf(status, confinement, signal);
}

}  // namespace mote::prep
