// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/supervise/supervise.h"

#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <optional>

namespace mote::server {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kPatience(5);

bool hasEnded(pid_t child) {
    siginfo_t info{};
    waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOHANG | WNOWAIT);
    return info.si_pid == child;
}

/// One of the signals; 0 where there was none until then.
int waitForSignal(const sigset_t& signals, const std::optional<Clock::time_point>& until) {
    if (!until) return std::max(sigwaitinfo(&signals, nullptr), 0);
    const auto left = std::max(*until - Clock::now(), Clock::duration::zero());
    const auto nanoseconds = std::chrono::duration_cast<std::chrono::nanoseconds>(left).count();
    const timespec wait{nanoseconds / 1'000'000'000, nanoseconds % 1'000'000'000};
    return std::max(sigtimedwait(&signals, nullptr, &wait), 0);
}

}  // namespace

ChildEnd waitForEnd(pid_t child, const sigset_t& signals, std::uint32_t timeLimit) {
    ChildEnd end;
    std::optional<Clock::time_point> lateAt, killAt;
    if (timeLimit > 0) lateAt = Clock::now() + std::chrono::seconds(timeLimit);
    while (!hasEnded(child)) {
        const int signal = waitForSignal(signals, killAt ? killAt : lateAt);
        const bool late = !killAt && lateAt && Clock::now() >= *lateAt;
        if (killAt && Clock::now() >= *killAt) {
            kill(-child, SIGKILL);
            killAt = Clock::now() + kPatience;
        } else if (late || (!killAt && signal == SIGTERM)) {
            end.late = late;
            kill(-child, SIGTERM);
            killAt = Clock::now() + kPatience;
        }
    }
    kill(-child, SIGKILL);  // what it left behind; its number is its own until it is waited for
    while (waitpid(child, &end.status, 0) < 0 && errno == EINTR) {
    }
    killLeftovers();
    return end;
}

std::string resultOf(const ChildEnd& end, std::uint32_t timeLimit) {
    if (end.late) return fmt::format("timeout {}\n", timeLimit);
    if (WIFSIGNALED(end.status)) return fmt::format("signal {}\n", WTERMSIG(end.status));
    return fmt::format("exit {}\n", WEXITSTATUS(end.status));
}

}  // namespace mote::server
