// SPDX-License-Identifier: GPL-3.0-or-later
//
// A wish to stop is asked for while an Interrupt is there, and breaks in again afterwards.
#include "client/shared/interrupt.h"

#include <gtest/gtest.h>

namespace mote::client {
namespace {

bool isBlocked(int signal) {
    sigset_t mask;
    pthread_sigmask(SIG_BLOCK, nullptr, &mask);
    return sigismember(&mask, signal) == 1;
}

TEST(Interrupt, SignalsAreBlockedWhileItIsThere) {
    ASSERT_FALSE(isBlocked(SIGTERM));
    {
        const Interrupt interrupt;
        EXPECT_TRUE(isBlocked(SIGINT) && isBlocked(SIGTERM) && isBlocked(SIGHUP));
        EXPECT_FALSE(interrupt.requested());
        std::raise(SIGTERM);
        EXPECT_TRUE(interrupt.requested());
        EXPECT_EQ(interrupt.signal(), SIGTERM);
    }
    EXPECT_FALSE(isBlocked(SIGINT) || isBlocked(SIGTERM) || isBlocked(SIGHUP));
}

}  // namespace
}  // namespace mote::client
