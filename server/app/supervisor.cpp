// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/supervisor.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <system_error>

#include "protocol/base/complain.h"
#include "protocol/base/json.h"
#include "protocol/mote.pb.h"
#include "server/log.h"
#include "storage/files/file_descriptor.h"

namespace mote::server {
namespace {

/// Of the process that serves; null before that.
std::atomic<CrashRecord*> servingRecord{nullptr};

constexpr int killedBy = 128;  // and the signal's number, as shells say it
constexpr std::array<int, 3> askingToEnd{SIGTERM, SIGINT, SIGHUP};

[[noreturn]] void throwSystemError(const char* what) {
    throw std::system_error(errno, std::generic_category(), what);
}

/// Where the handler writes: one supervisor a process.
int signalPipe = -1;

/// What a terminal sends reaches the child without us: its number is told as a negative one.
void passOn(int number, siginfo_t* info, void*) {
    const int before = errno;
    const auto byte = static_cast<signed char>(info->si_code == SI_KERNEL ? -number : number);
    [[maybe_unused]] const auto ignored = ::write(signalPipe, &byte, 1);
    errno = before;
}

/// Handlers rather than a mask: libraries have threads of their own, which a mask of ours does not reach.
class EndSignals {
  public:
    EndSignals() {
        std::array<int, 2> ends{};
        if (::pipe2(ends.data(), O_CLOEXEC | O_NONBLOCK) != 0) throwSystemError("a pipe");
        reader_ = storage::FileDescriptor(ends[0]);
        writer_ = storage::FileDescriptor(ends[1]);
        signalPipe = ends[1];
        struct sigaction action {};
        action.sa_sigaction = passOn;
        action.sa_flags = SA_SIGINFO | SA_RESTART;
        for (std::size_t i = 0; i < askingToEnd.size(); ++i) {
            ::sigaction(askingToEnd[i], nullptr, &before_[i]);
            // Who started us under nohup wants no SIGHUP.
            if (before_[i].sa_handler != SIG_IGN) ::sigaction(askingToEnd[i], &action, nullptr);
        }
    }
    ~EndSignals() { restore(); }
    EndSignals(const EndSignals&) = delete;
    EndSignals& operator=(const EndSignals&) = delete;

    void restore() const {
        for (std::size_t i = 0; i < askingToEnd.size(); ++i)
            ::sigaction(askingToEnd[i], &before_[i], nullptr);
    }

    /// Readable when a signal came.
    int descriptor() const { return reader_.get(); }
    /// Its number, negative where the child has it too; 0 where none came.
    int take() const {
        signed char byte = 0;
        return ::read(reader_.get(), &byte, 1) == 1 ? byte : 0;
    }

  private:
    storage::FileDescriptor reader_, writer_;
    std::array<struct sigaction, askingToEnd.size()> before_{};
};

/// Holds this thread's signals back for a while: a child must not run our handlers.
class NoSignals {
  public:
    NoSignals() {
        sigset_t all;
        ::sigfillset(&all);
        ::pthread_sigmask(SIG_SETMASK, &all, &before_);
    }
    ~NoSignals() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
    NoSignals(const NoSignals&) = delete;
    NoSignals& operator=(const NoSignals&) = delete;

  private:
    sigset_t before_{};
};

/// Runs in the child. Ends without destroying what is static: libraries would wait there for threads of
/// theirs that did not come along.
[[noreturn]] void become(const std::function<int()>& serve, const EndSignals& signals, pid_t supervisor) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    log::reopen();
    if (::getppid() != supervisor) std::_Exit(killedBy + SIGKILL);  // it died before that
    signals.restore();
    int code = EXIT_FAILURE;
    try {
        sigset_t none;
        ::sigemptyset(&none);
        ::pthread_sigmask(SIG_SETMASK, &none, nullptr);
        code = serve();
    } catch (const std::exception& failure) {
        complain("mote-server", failure.what());
    }
    std::fflush(nullptr);
    std::_Exit(code);
}

pid_t start(const std::function<int()>& serve, const EndSignals& signals) {
    const NoSignals held;
    const pid_t supervisor = ::getpid();
    const pid_t child = ::fork();
    if (child < 0) throwSystemError("no process can be made");
    if (child == 0) become(serve, signals, supervisor);
    return child;
}

/// How a child ended, as waitpid tells it, and whether it had been asked to.
struct End {
    int status = 0;
    bool asked = false;
};

End waitForEnd(pid_t child, const EndSignals& signals) {
    const storage::FileDescriptor process(static_cast<int>(::syscall(SYS_pidfd_open, child, 0)));
    if (!process.valid()) throwSystemError("a process cannot be watched");
    End end;
    for (;;) {
        std::array<pollfd, 2> events{pollfd{process.get(), POLLIN, 0},
                                     pollfd{signals.descriptor(), POLLIN, 0}};
        if (::poll(events.data(), events.size(), -1) < 0 && errno != EINTR) throwSystemError("poll");
        while (const int number = signals.take()) {
            end.asked = true;
            if (number > 0) ::kill(child, number);
        }
        if (::waitpid(child, &end.status, WNOHANG) == child) return end;
    }
}

/// The view as a script would hold it: JSON has no control characters. A view of the longest kind is cut.
std::string textOf(const std::string& bytes) {
    constexpr std::size_t longest = std::size_t{1} << 16;
    proto::View view;
    return view.ParseFromString(bytes) ? toJsonLine(view).substr(0, longest) : "(its text is lost)";
}

void tell(CrashRecord& record, int signal) {
    log::reopen();  // the dead process wrote to it
    log::error("the server was ended by SIG{}{} and starts again", ::sigabbrev_np(signal),
               record.wasShortOfMemory() ? ", as there was no memory left for it," : "");
    const auto view = record.view();
    if (!view) return;
    const unsigned deaths = record.count(*view);
    log::error("it was drawing this view{}: {}",
               deaths >= refusedAfterDeaths ? ", which is refused from now on" : "", textOf(*view));
}

}  // namespace

void endWithoutMemory(CrashRecord& record) {
    servingRecord = &record;
}

int supervise(CrashRecord& record, const std::function<int(bool again)>& serve) {
    const EndSignals signals;
    for (bool again = false;; again = true) {
        record.clear();
        const pid_t child = start([&] { return serve(again); }, signals);
        const End end = waitForEnd(child, signals);
        if (WIFEXITED(end.status)) return WEXITSTATUS(end.status);
        const int signal = WTERMSIG(end.status);
        if (end.asked || !record.wasReady()) return killedBy + signal;
        try {
            tell(record, signal);
        } catch (const std::exception& failure) {
            log::failure("the server starts again",
                         failure);  // that is worth more than what there is to tell
        }
    }
}

}  // namespace mote::server

// Never inlined: g++ 12 takes the free() of an inlined operator delete for a mistake.
[[gnu::noinline]] void* operator new(std::size_t size) {
    if (void* const found = std::malloc(size > 0 ? size : 1)) return found;
    auto* const record = mote::server::servingRecord.load();
    if (record == nullptr || size >= mote::server::littleMemory) throw std::bad_alloc();
    record->shortOfMemory();
    std::abort();
}

[[gnu::noinline]] void operator delete(void* memory) noexcept {
    std::free(memory);
}

[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}
