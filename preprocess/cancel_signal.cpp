// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/cancel_signal.h"

#include <atomic>
#include <csignal>

namespace mote::prep {
namespace {

// A signal handler reaches nothing but what is static.
std::atomic<int> receivedSignal{0};
static_assert(std::atomic<int>::is_always_lock_free);

extern "C" void onSignal(int number) {
    receivedSignal.store(number, std::memory_order_relaxed);
}

}  // namespace

CancelSignal::CancelSignal() {
    struct sigaction action {};
    action.sa_handler = onSignal;
    // The second one finds the default action.
    action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
    ::sigaction(SIGINT, &action, nullptr);
    ::sigaction(SIGTERM, &action, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
}

int CancelSignal::received() const {
    return receivedSignal.load(std::memory_order_relaxed);
}

}  // namespace mote::prep
