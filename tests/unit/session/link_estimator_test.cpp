// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/session/flow_control.h"

#include <gtest/gtest.h>

#include "tests/unit/session/simulated_link.h"

namespace mote::server {
namespace {

using namespace std::chrono_literals;
using test::SimulatedLink;

double ms(Clock::duration duration) {
    return milliseconds(duration);
}

class LinkEstimatorTest : public testing::Test {
  protected:
    void send(std::uint64_t bytes) {
        estimator_.sent(now_, bytes);
        link_.send(now_, bytes);
    }
    /// A frame as the server sends it: a small piece, then the rest.
    void sendFrame(std::uint64_t bytes) {
        send(512);
        send(bytes - 512);
    }
    void passTo(Clock::time_point end) {
        while (link_.nextArrival() && *link_.nextArrival() <= end) {
            now_ = *link_.nextArrival();
            EXPECT_TRUE(estimator_.received(now_, link_.next(now_)->total));
        }
        now_ = end;
    }

    Clock::time_point now_{100s};
    SimulatedLink link_;
    LinkEstimator estimator_;
};

TEST_F(LinkEstimatorTest, KnowsNothingBeforeTheFirstReceipt) {
    EXPECT_FALSE(estimator_.rate());
    EXPECT_FALSE(estimator_.roundTrip());
    send(1000);
    EXPECT_FALSE(estimator_.rate());
    EXPECT_EQ(estimator_.inFlight(), 1000u);
}

TEST_F(LinkEstimatorTest, FindsRateAndRoundTripWhetherTheLinkIsIdleOrBusy) {
    for (const double rate : {0.25e6, 2.5e6, 25e6}) {
        for (const auto period : {10ms, 33ms, 500ms}) {
            estimator_ = {};
            link_ = SimulatedLink(rate, 50ms);
            // Frames that fill from a tenth to all of the link's time.
            const auto bytes = static_cast<std::uint64_t>(0.9 * rate * 1e-3 * ms(std::min(period, 33ms)));
            for (int i = 0; i < 60; ++i) {
                sendFrame(std::max<std::uint64_t>(bytes, 4096));
                passTo(now_ + period);
            }
            passTo(now_ + 2s);
            // The probe takes its own time of the link, which counts as delay: 2 KiB of each frame are too
            // many.
            const double probe = 512.0 / static_cast<double>(std::max<std::uint64_t>(bytes, 4096));
            EXPECT_NEAR(*estimator_.rate() / rate, 1.0, 0.02 + probe) << rate << " " << period.count();
            EXPECT_NEAR(ms(*estimator_.roundTrip()), 100.0 + 512.0 / rate * 1e3, 0.5);
            EXPECT_EQ(estimator_.inFlight(), 0u);
        }
    }
}

TEST_F(LinkEstimatorTest, APauseTeachesNothing) {
    for (int i = 0; i < 30; ++i) {
        sendFrame(60000);
        passTo(now_ + 33ms);
    }
    passTo(now_ + 1s);
    const double before = *estimator_.rate();
    passTo(now_ + 1h);
    EXPECT_EQ(*estimator_.rate(), before);
    sendFrame(60000);
    passTo(now_ + 1s);
    EXPECT_NEAR(*estimator_.rate(), before, 0.05 * before);
}

TEST_F(LinkEstimatorTest, FollowsALinkThatChanges) {
    for (const double rate : {2.5e6, 0.5e6, 5e6}) {
        link_.bytesPerSecond = rate;
        for (int i = 0; i < 60; ++i) {
            sendFrame(15000);
            passTo(now_ + 33ms);
        }
        passTo(now_ + 1s);
        // 60 frames of which the last 8 weigh as much as all before them: e^-7 is left of the old rate. The
        // probe is 14 % of a frame.
        EXPECT_NEAR(*estimator_.rate() / rate, 1.0, 0.2) << rate;
    }
}

TEST_F(LinkEstimatorTest, ABusyMachineDoesNotLookLikeAThinLink) {
    for (int i = 0; i < 60; ++i) {
        link_.oneWay = 50ms + (i * 37 % 9) * 1ms;  // each frame is looked at up to 8 ms late, both ways
        sendFrame(40000);
        passTo(now_ + 200ms);
    }
    EXPECT_NEAR(*estimator_.rate(), 2.5e6, 0.05 * 2.5e6);
}

TEST_F(LinkEstimatorTest, AClientThatSleptIsSoonForgiven) {
    link_ = SimulatedLink(200e6, 100us);
    for (int i = 0; i < 30; ++i) {
        sendFrame(300000);
        passTo(now_ + 33ms);
    }
    link_.oneWay = 3s;  // it is stopped
    sendFrame(300000);
    passTo(now_ + 7s);
    link_.oneWay = 100us;
    for (int i = 0; i < 15; ++i) {
        sendFrame(300000);
        passTo(now_ + 33ms);
    }
    // The sleep weighs 0.1 s at 0.05 MB/s; after 30 receipts e^-2 of it is left beside 15 frames of 1.5 ms.
    EXPECT_GT(*estimator_.rate(), 50e6);
}

TEST_F(LinkEstimatorTest, ReceiptsAtOnceAreNoFastLink) {
    // A browser that was busy with its first picture says of all its pieces at once that they are there.
    for (int i = 0; i < 6; ++i) send(16384);
    for (std::uint64_t i = 1; i <= 6; ++i)
        EXPECT_TRUE(estimator_.received(now_ + 300ms + i * 30us, i * 16384));
    EXPECT_FALSE(estimator_.rate());
    now_ += 400ms;
    for (int i = 0; i < 6; ++i) send(16384);
    EXPECT_TRUE(estimator_.received(now_ + 400ms, 12 * 16384));
    EXPECT_LT(*estimator_.rate(), 2e6);
}

TEST_F(LinkEstimatorTest, RefusesWhatCannotBe) {
    send(1000);
    send(1000);
    EXPECT_FALSE(estimator_.received(now_ + 1s, 2001));
    EXPECT_TRUE(estimator_.received(now_ + 1s, 1000));
    EXPECT_FALSE(estimator_.received(now_ + 1s, 999));
    EXPECT_TRUE(estimator_.received(now_ + 1s, 1500));  // half of a piece says nothing yet
    EXPECT_EQ(estimator_.inFlight(), 1000u);
}

}  // namespace
}  // namespace mote::server
