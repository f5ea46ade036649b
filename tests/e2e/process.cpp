// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/e2e/process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <system_error>

namespace mote::test {
namespace {

[[noreturn]] void throwSystemError(const char* what) {
    throw std::system_error(errno, std::generic_category(), what);
}

std::array<int, 2> makePipe() {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) throwSystemError("pipe");
    ::fcntl(ends[0], F_SETFL, O_NONBLOCK);
    return ends;
}

/// In the child.
[[noreturn]] void become(std::vector<char*>& words, int output, int errors, const ProcessOptions& options) {
    ::dup2(::open("/dev/null", O_RDONLY | O_CLOEXEC), STDIN_FILENO);
    ::dup2(output, STDOUT_FILENO);
    ::dup2(errors, STDERR_FILENO);
    if (options.fileSizeLimit) {
        const rlimit limit{*options.fileSizeLimit, *options.fileSizeLimit};
        ::setrlimit(RLIMIT_FSIZE, &limit);
    }
    // The test programs have one thread here, so that this allocation is safe.
    for (const auto& [name, value] : options.environment) ::setenv(name.c_str(), value.c_str(), 1);
    ::execv(words.front(), words.data());
    ::_exit(127);
}

/// Closes the pipe at its end: poll() would tell of it again and again.
void readAvailable(int& pipe, std::string& text) {
    std::array<char, 4096> buffer{};
    ssize_t count = 0;
    while (pipe >= 0 && (count = ::read(pipe, buffer.data(), buffer.size())) > 0) {
        text.append(buffer.data(), static_cast<std::size_t>(count));
    }
    if (pipe < 0 || count != 0) return;
    ::close(pipe);
    pipe = -1;
}

}  // namespace

Process::Process(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                 const ProcessOptions& options) {
    std::vector<std::string> texts{program.string()};
    texts.insert(texts.end(), arguments.begin(), arguments.end());
    std::vector<char*> words;
    for (auto& text : texts) words.push_back(text.data());
    words.push_back(nullptr);
    const auto output = makePipe(), errors = makePipe();
    id_ = ::fork();
    if (id_ < 0) throwSystemError("fork");
    if (id_ == 0) become(words, output[1], errors[1], options);
    ::close(output[1]);
    ::close(errors[1]);
    outputPipe_ = output[0];
    errorPipe_ = errors[0];
    process_ = static_cast<int>(::syscall(SYS_pidfd_open, id_, 0));
    if (process_ < 0) throwSystemError("pidfd_open");
}

Process::~Process() {
    if (!status_) {
        ::kill(id_, SIGKILL);
        ::waitpid(id_, nullptr, 0);
    }
    for (const int each : {process_, outputPipe_, errorPipe_}) {
        if (each >= 0) ::close(each);
    }
}

void Process::signal(int number) const {
    if (!status_) ::kill(id_, number);
}

bool Process::readUntil(Time end) {
    const auto left = std::chrono::duration_cast<Timeout>(end - std::chrono::steady_clock::now());
    std::array<pollfd, 3> descriptors{pollfd{process_, POLLIN, 0}, pollfd{outputPipe_, POLLIN, 0},
                                      pollfd{errorPipe_, POLLIN, 0}};
    ::poll(descriptors.data(), descriptors.size(), static_cast<int>(std::max<long>(0, left.count())));
    drain();
    return (descriptors[0].revents & POLLIN) != 0;
}

void Process::drain() {
    readAvailable(outputPipe_, output_);
    readAvailable(errorPipe_, errors_);
}

std::optional<int> Process::wait(Timeout timeout) {
    const auto end = std::chrono::steady_clock::now() + timeout;
    while (!status_) {
        const bool ended = readUntil(end);
        if (!ended && std::chrono::steady_clock::now() >= end) return std::nullopt;
        if (!ended) continue;
        int status = 0;
        if (::waitpid(id_, &status, 0) != id_) throwSystemError("waitpid");
        drain();
        status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }
    return status_;
}

bool Process::waitForOutput(const std::string& text, Timeout timeout) {
    const auto end = std::chrono::steady_clock::now() + timeout;
    while (output_.find(text) == std::string::npos) {
        const bool ended = readUntil(end);
        if (output_.find(text) != std::string::npos) return true;
        if (ended || std::chrono::steady_clock::now() >= end) return false;
    }
    return true;
}

bool waitForEnd(pid_t process, Process::Timeout timeout) {
    const int file = static_cast<int>(::syscall(SYS_pidfd_open, process, 0));
    if (file < 0) return errno == ESRCH;
    pollfd ended{file, POLLIN, 0};
    const bool gone = ::poll(&ended, 1, static_cast<int>(timeout.count())) == 1;
    ::close(file);
    return gone;
}

Finished runProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                    const ProcessOptions& options) {
    Process process(program, arguments, options);
    const auto status = process.wait(2 * Process::patience);
    return {status.value_or(124), process.output(), process.errors()};
}

}  // namespace mote::test
