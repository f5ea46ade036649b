// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/views/check_worker.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <iostream>
#include <system_error>

#include "protocol/base/json.h"

namespace mote::test {
namespace {

// Of the processor, whatever else the machine does. Under sanitizers a view takes some seconds; nothing may
// take this long.
constexpr double patience = 60.0;  // seconds
constexpr int glance = 500;        // milliseconds between looks at how long it took

std::array<int, 2> makePipe() {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
    return ends;
}

std::string howItEnded(int status) {
    if (WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL)
        return fmt::format("took more than {} s, or too much memory", patience);
    if (WIFSIGNALED(status)) return fmt::format("ended by signal {}", WTERMSIG(status));
    return fmt::format("ended with status {}", WEXITSTATUS(status));
}

/// Seconds that a process has had of the processor.
double processorTime(pid_t process) {
    clockid_t clock{};
    timespec time{};
    if (clock_getcpuclockid(process, &clock) != 0 || clock_gettime(clock, &time) != 0) return 0.0;
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

CheckWorker::~CheckWorker() {
    if (process_ > 0) end();
}

void CheckWorker::start() {
    const auto in = makePipe(), out = makePipe();
    std::vector<char*> arguments{const_cast<char*>("check-views")};
    for (auto& argument : arguments_) arguments.push_back(argument.data());
    arguments.push_back(nullptr);
    process_ = fork();
    if (process_ < 0) throw std::system_error(errno, std::generic_category(), "fork");
    if (process_ == 0) {
        dup2(in[0], STDIN_FILENO);
        dup2(out[1], STDOUT_FILENO);
        execv("/proc/self/exe", arguments.data());
        _exit(127);
    }
    close(in[0]);
    close(out[1]);
    toIt_ = in[1];
    fromIt_ = out[0];
    unread_.clear();
}

std::string CheckWorker::end() {
    close(toIt_);
    close(fromIt_);
    int status = 0;
    while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    process_ = -1;
    return howItEnded(status);
}

bool CheckWorker::writeLine(const std::string& line) const {
    for (std::size_t done = 0; done < line.size();) {
        const ssize_t written = write(toIt_, line.data() + done, line.size() - done);
        if (written < 0 && errno != EINTR) return false;
        if (written > 0) done += static_cast<std::size_t>(written);
    }
    return true;
}

bool CheckWorker::readLine(std::string& line) {
    const double limit = processorTime(process_) + patience;
    while (true) {
        if (const auto at = unread_.find('\n'); at != std::string::npos) {
            line = unread_.substr(0, at);
            unread_.erase(0, at + 1);
            return true;
        }
        pollfd waiting{fromIt_, POLLIN, 0};
        if (poll(&waiting, 1, glance) <= 0) {
            if (processorTime(process_) > limit) kill(process_, SIGKILL);
            continue;
        }
        std::array<char, 4096> bytes{};
        const ssize_t count = read(fromIt_, bytes.data(), bytes.size());
        if (count <= 0) return false;
        unread_.append(bytes.data(), static_cast<std::size_t>(count));
    }
}

Verdict CheckWorker::examine(const proto::View& view) {
    if (process_ < 0) start();
    std::string line;
    if (!writeLine(toJsonLine(view) + '\n') || !readLine(line)) {
        Verdict verdict{.kind = Verdict::Kind::dead};
        verdict.text = end();
        return verdict;
    }
    const auto verdict = Verdict::parse(line);
    if (!verdict.ok()) throw std::runtime_error(verdict.error().toString());
    return *verdict;
}

void serveChecks(ViewCheck& check) {
    std::string line;
    while (std::getline(std::cin, line)) {
        proto::View view;
        const auto parsed = parseJson(line, view, "view");
        if (!parsed.ok()) throw std::runtime_error(parsed.error().toString());
        std::cout << check.check(view).toLine() << std::endl;
    }
}

}  // namespace mote::test
