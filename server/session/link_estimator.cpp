// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/session/link_estimator.h"

#include <algorithm>
#include <cmath>

namespace mote::server {
namespace {

using Seconds = std::chrono::duration<double>;
using namespace std::chrono_literals;

// Measurements are forgotten by the time that the link was busy, not by the clock: a pause teaches nothing.
constexpr double memory = 0.3;      // s
constexpr double samples = 16.0;    // that are remembered at most, so that one bad one is soon made good
constexpr double mostWeight = 0.1;  // s, of one: a client that slept says little of its link
constexpr Clock::duration shortest = 20us;  // no receipt is timed better than that
constexpr Clock::duration stretch = 10s;    // a round trip is believed for one to two of these

}  // namespace

void LinkEstimator::sent(Clock::time_point now, std::uint64_t bytes) {
    sent_ += bytes;
    pieces_.push_back({sent_, now});
    idleAt_ = std::max(idleAt_, now);
    if (const auto perSecond = rate()) {
        idleAt_ +=
            std::chrono::duration_cast<Clock::duration>(Seconds(static_cast<double>(bytes) / *perSecond));
    }
}

bool LinkEstimator::received(Clock::time_point now, std::uint64_t total) {
    if (total > sent_ || total < received_) return false;
    std::optional<Clock::time_point> first, last;  // when the pieces that are now whole were sent
    std::uint64_t whole = received_;
    while (!pieces_.empty() && pieces_.front().end <= total) {
        if (!first) first = pieces_.front().sent;
        last = pieces_.front().sent;
        whole = pieces_.front().end;
        pieces_.pop_front();
    }
    const std::uint64_t bytes = whole - received_;
    received_ = whole;
    if (!first) return true;
    learnRoundTrip(now, now - *last);
    // The link began with them when they reached it, or when it was through with those before.
    const auto begun = std::max(lastReceipt_, *first + *roundTrip());
    // What reached an idle link only tells how much longer than ever it took, and a machine that was busy
    // takes longer too: where more is behind it, that tells better.
    const bool reachedIdle = begun > lastReceipt_;
    if (begun < now && (!reachedIdle || inFlight() == 0)) learnRate(bytes, std::max(now - begun, shortest));
    lastReceipt_ = now;
    if (!rate()) return true;
    // The last of what is left arrives then at the earliest, and left the link at most a round trip before.
    const auto arrives =
        now + std::chrono::duration_cast<Clock::duration>(Seconds(static_cast<double>(inFlight()) / *rate()));
    idleAt_ = std::clamp(idleAt_, arrives - *roundTrip(), arrives);
    return true;
}

void LinkEstimator::learnRoundTrip(Clock::time_point now, Clock::duration sample) {
    if (now - stretchBegan_ > stretch) {
        leastBefore_ = std::exchange(least_, std::nullopt);
        stretchBegan_ = now;
    }
    least_ = least_ ? std::min(*least_, sample) : sample;
}

void LinkEstimator::learnRate(std::uint64_t bytes, Clock::duration busy) {
    const double seconds = Seconds(busy).count();
    const double weight = std::min(1.0, mostWeight / seconds);
    const double kept = std::exp(-std::max(weight * seconds / memory, 1.0 / samples));
    bytes_ = kept * bytes_ + weight * static_cast<double>(bytes);
    seconds_ = kept * seconds_ + weight * seconds;
}

std::optional<double> LinkEstimator::rate() const {
    if (seconds_ <= 0.0) return std::nullopt;
    return bytes_ / seconds_;
}

std::optional<Clock::duration> LinkEstimator::roundTrip() const {
    if (least_ && leastBefore_) return std::min(*least_, *leastBefore_);
    return least_ ? least_ : leastBefore_;
}

}  // namespace mote::server
