// SPDX-License-Identifier: GPL-3.0-or-later
//
// Flow control against simulated links: how many frames a second, how old they are, what queues, and how they
// are encoded.
#include "server/session/flow_control.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/unit/session/simulated_link.h"

namespace mote::server {
namespace {

using namespace std::chrono_literals;
using test::SimulatedLink;

/// A hand that never rests: each frame that may be begun is drawn in `work` and holds what it may hold.
class Orbit {
  public:
    Orbit(SimulatedLink link, Clock::duration work) : link_(link), work_(work) {}

    void run(Clock::duration length) {
        const auto end = now_ + length;
        for (; now_ < end; now_ += 1ms) {
            receive();
            for (auto count = flow_.begin(now_); count > 0; --count) begun_.push_back(now_);
            if (!begun_.empty() && now_ >= drawnAt()) draw();
        }
    }
    void stopReading() { reading_ = false; }
    void reshape(double bytesPerSecond) { link_.bytesPerSecond = bytesPerSecond; }

    struct Shown {
        Clock::time_point begun, at;
    };
    std::vector<Shown> shown;
    std::vector<proto::Frame::Encoding> encodings;  ///< of what was drawn
    /// What a picture takes without loss: at first more than any link carries.
    std::size_t losslessBytes = std::size_t{1} << 40;
    std::uint64_t sentBytes = 0;
    double mostWaiting = 0.0;  ///< bytes that waited for the link when a frame was sent, that frame included
    FlowControl flow_{true, 16};

  private:
    Clock::time_point drawnAt() const { return std::max(begun_.front(), drawn_) + work_; }

    void draw() {
        const std::size_t bytes = encode();
        flow_.made(bytes, milliseconds(work_), true);
        for (std::size_t begin = 0; begin < bytes;) {
            const std::size_t size = flow_.piece(now_, begin, bytes - begin, false);
            ASSERT_GT(size, 0u);
            flow_.sent(now_, size, begin == 0, begin + size == bytes);
            begin += size;
            mostWaiting = std::max(mostWaiting, link_.send(now_, size));
            inLink_.push_back({begun_.front(), begin == bytes});
        }
        sentBytes += bytes;
        drawn_ = now_;
        begun_.erase(begun_.begin());
    }

    /// Returns how many bytes it takes.
    std::size_t encode() {
        const bool wasLossless = !encodings.empty() && encodings.back() == proto::Frame::ZSTD;
        encodings.push_back(
            chooseEncoding({true, true, flow_.frameBytes()}, {false, losslessBytes, wasLossless}));
        if (encodings.back() == proto::Frame::ZSTD) return losslessBytes;
        return std::min<std::size_t>(flow_.frameBytes().value_or(unmeasuredFrameBytes), 300000);
    }

    void receive() {
        while (auto receipt = reading_ ? link_.next(now_) : std::nullopt) {
            proto::Credit credit;
            credit.set_received_bytes(receipt->total);
            if (inLink_.front().last) {
                credit.set_frames(1);
                shown.push_back({inLink_.front().begun, receipt->arrives - link_.oneWay});
            }
            inLink_.pop_front();
            ASSERT_TRUE(flow_.returned(receipt->arrives, credit).ok());
        }
    }

    struct InLink {
        Clock::time_point begun;
        bool last;
    };
    SimulatedLink link_;
    const Clock::duration work_;
    Clock::time_point now_{100s}, drawn_;
    std::vector<Clock::time_point> begun_;
    std::deque<InLink> inLink_;
    bool reading_ = true;
};

TEST(FlowControl, FillsALongLinkWithoutAQueue) {
    for (const double rate : {0.5e6, 2.5e6, 12.5e6}) {
        Orbit orbit({rate, 50ms}, 12ms);
        orbit.run(1s);  // it measures
        orbit.shown.clear();
        orbit.mostWaiting = 0.0;
        orbit.run(5s);
        EXPECT_GE(orbit.shown.size(), 5u * 28u) << rate;
        // From the begin of its drawing: 12 ms, a frame's time on the link (25 ms) and what is left of the
        // one before it when it is drawn, the way of 50 ms, and steps of 1 ms.
        for (const auto& frame : orbit.shown)
            EXPECT_LE(milliseconds(frame.at - frame.begun), 12 + 2 * 27 + 50 + 3);
        EXPECT_LE(orbit.mostWaiting, 2.2 * static_cast<double>(*orbit.flow_.frameBytes())) << rate;
    }
}

TEST(FlowControl, KeepsTheDeviceBusyOnAFastLink) {
    Orbit orbit({500e6, 50us}, 5ms);
    orbit.run(1s);
    orbit.shown.clear();
    orbit.run(2s);
    EXPECT_GE(orbit.shown.size(), 2u * 150u);  // 5 ms each, and steps of 1 ms between
}

TEST(FlowControl, AThinnerLinkIsNoticedBeforeMuchQueues) {
    Orbit orbit({2.5e6, 50ms}, 12ms);
    orbit.run(3s);
    orbit.reshape(0.5e6);
    orbit.run(3s);
    orbit.shown.clear();
    orbit.run(3s);
    EXPECT_GE(orbit.shown.size(), 3u * 25u);
    EXPECT_LE(milliseconds(orbit.shown.back().at - orbit.shown.back().begun), 12 + 2 * 27 + 50 + 3);
}

/// 1280 x 960 that points fill, at a third of the resolution. tests/e2e/link_test.cpp has such a client, but
/// no say in how fast its machine is.
TEST(FlowControl, AThinLinkGetsH264AndAWideOneLosslessPicturesHoweverBusyTheMachine) {
    for (const auto work : {5ms, 30ms, 200ms}) {
        Orbit thin({62500.0, 20ms}, work), wide({500e6, 50us}, work);
        for (Orbit* orbit : {&thin, &wide}) {
            orbit->losslessBytes = 100000;
            orbit->run(2s);  // it measures
            EXPECT_EQ(orbit->encodings.front(), proto::Frame::H264) << "of a link that nothing is known of";
            orbit->encodings.clear();
            orbit->run(5s);
            EXPECT_GE(orbit->encodings.size(), 20u);
        }
        EXPECT_THAT(thin.encodings, testing::Each(proto::Frame::H264)) << milliseconds(work);
        EXPECT_THAT(wide.encodings, testing::Each(proto::Frame::ZSTD)) << milliseconds(work);
    }
}

TEST(FlowControl, AClientThatDoesNotReadCostsTwoFrames) {
    Orbit orbit({2.5e6, 50ms}, 5ms);
    orbit.stopReading();
    orbit.run(10s);
    EXPECT_LE(orbit.sentBytes, 2 * unmeasuredFrameBytes);
}

TEST(FlowControl, AClientThatStopsReadingCostsWhatThePipeHoldsAndAFewFrames) {
    Orbit orbit({2.5e6, 50ms}, 5ms);
    orbit.run(3s);
    const auto before = orbit.sentBytes;
    orbit.stopReading();
    orbit.run(10s);
    EXPECT_LE(orbit.sentBytes - before, 1.5 * 0.25e6 + 3.0 * 62500);
}

TEST(FlowControl, WithoutReceiptsTwoCreditsAreAll) {
    FlowControl flow(false, 2);
    const Clock::time_point now{1s};
    EXPECT_EQ(flow.begin(now), 2u);
    EXPECT_EQ(flow.begin(now), 0u);
    flow.made(1000, 1.0, true);
    EXPECT_EQ(flow.piece(now, 0, 1000, true), 1000u);
    flow.sent(now, 1000, true, true);
    EXPECT_EQ(flow.begin(now), 0u);
    proto::Credit credit;
    credit.set_frames(1);
    EXPECT_TRUE(flow.returned(now, credit).ok());
    EXPECT_EQ(flow.begin(now), 1u);
    EXPECT_EQ(flow.returned(now, credit).error().where, "credit.frames");
    EXPECT_FALSE(flow.due(now));
    EXPECT_FALSE(flow.frameBytes());
}

TEST(FlowControl, AFrameThatCanWaitGoesInPiecesAsTheLinkTakesThem) {
    FlowControl flow(true, 16);
    SimulatedLink link{2.5e6, 50ms};
    Clock::time_point now{100s};
    ASSERT_EQ(flow.begin(now), 2u);
    flow.made(300000, 10.0, false);
    std::size_t begin = 0;
    double mostWaiting = 0.0;
    while (begin < 300000) {
        while (const auto receipt = link.next(now)) {
            proto::Credit credit;
            credit.set_received_bytes(receipt->total);
            ASSERT_TRUE(flow.returned(receipt->arrives, credit).ok());
        }
        if (const auto size = flow.piece(now, begin, 300000 - begin, true); size > 0) {
            flow.sent(now, size, begin == 0, begin + size == 300000);
            mostWaiting = std::max(mostWaiting, link.send(now, size));
            begin += size;
        }
        now += 1ms;
    }
    // What a newer frame would wait for: a piece on its way and one behind it, 10 ms each, and a step of 1
    // ms; of an unknown link the first three pieces, which is less.
    EXPECT_LE(mostWaiting, 2.5e6 * 0.022);
    // 120 ms of the link, and the first round trips of an unknown one.
    EXPECT_LE(milliseconds(now - Clock::time_point{100s}), 120 + 3 * 100);
}

TEST(FlowControl, WhatWasNotSentCannotBeReceived) {
    FlowControl flow(true, 16);
    proto::Credit credit;
    credit.set_received_bytes(1);
    EXPECT_EQ(flow.returned(Clock::time_point{1s}, credit).error().where, "credit.received_bytes");
}

}  // namespace
}  // namespace mote::server
