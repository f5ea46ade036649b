// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/interrupt.h"

#include <sys/signalfd.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace mote::client {

Interrupt::Interrupt() {
    sigset_t wanted;
    sigemptyset(&wanted);
    for (const int each : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&wanted, each);
    if (pthread_sigmask(SIG_BLOCK, &wanted, &before_) != 0) {
        throw std::system_error(errno, std::generic_category(), "signals cannot be blocked");
    }
    descriptor_ = ::signalfd(-1, &wanted, SFD_NONBLOCK | SFD_CLOEXEC);
    if (descriptor_ < 0) throw std::system_error(errno, std::generic_category(), "signalfd");
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
}

Interrupt::~Interrupt() {
    ::close(descriptor_);
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

bool Interrupt::requested() const {
    signalfd_siginfo info{};
    if (signal_ == 0 && ::read(descriptor_, &info, sizeof(info)) == sizeof(info)) {
        signal_ = static_cast<int>(info.ssi_signo);
    }
    return signal_ != 0;
}

void Interrupt::restoreInChild() const {
    std::signal(SIGPIPE, SIG_DFL);
    std::signal(SIGXFSZ, SIG_DFL);
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

}  // namespace mote::client
