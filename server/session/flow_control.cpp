// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/session/flow_control.h"

#include <algorithm>
#include <cmath>

#include "protocol/base/mote_check.h"

namespace mote::server {
namespace {

using Seconds = std::chrono::duration<double>;
using namespace std::chrono_literals;

constexpr std::uint32_t mostBegun = 2;    // one is drawn while the one before it is encoded
constexpr std::uint32_t mostHeld = 3;     // received and not yet shown: a slow client is not drowned
constexpr std::uint32_t unmeasured = 2;   // frames in flight before the first receipt
constexpr double frameRate = 30.0;        // that the link shall carry
constexpr double share = 0.75;            // of the link, so that what queues in it goes away again
constexpr double late = 0.2;              // weight of the latest frame in a mean
constexpr std::size_t probeBytes = 512;   // a first piece so small that its receipt tells the round trip
constexpr Clock::duration noProbe = 5ms;  // frames that take no longer need none
constexpr std::size_t leastPiece = 16 << 10;
constexpr Clock::duration pieceTime = 10ms;  // that a piece which can wait keeps the link busy

Clock::duration duration(double seconds) {
    return std::chrono::duration_cast<Clock::duration>(Seconds(std::min(seconds, 60.0)));
}

// Measurements are forgotten by the time that the link was busy, not by the clock: a pause teaches nothing.
constexpr double memory = 0.3;      // s
constexpr double samples = 16.0;    // that are remembered at most, so that one bad one is soon made good
constexpr double mostWeight = 0.1;  // s, of one: a client that slept says little of its link
constexpr Clock::duration shortest = 20us;  // no receipt is timed better than that
constexpr Clock::duration atOnce = 1ms;     // receipts that come together
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
    times_ += now - lastReceipt_ > atOnce ? 1 : 0;
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
    if (seconds_ <= 0.0 || times_ < 2) return std::nullopt;
    return bytes_ / seconds_;
}

std::optional<Clock::duration> LinkEstimator::roundTrip() const {
    if (least_ && leastBefore_) return std::min(*least_, *leastBefore_);
    return least_ ? least_ : leastBefore_;
}

Clock::duration FlowControl::linkTime(double bytes) const {
    const auto rate = link_.rate();
    return rate ? duration(bytes / *rate) : Clock::duration::zero();
}

/// What the pipe holds, a frame or two, and something for measurements that are off.
double FlowControl::mostInFlight() const {
    const double pipe = *link_.rate() * Seconds(*link_.roundTrip()).count();
    return 1.5 * pipe + 2.0 * std::max(meanBytes_, double{leastPiece});
}

bool FlowControl::mayBegin(Clock::time_point now) const {
    if (begun_ + waiting_ + outstanding_ >= credits_) return false;
    if (!measured_) return true;
    const std::uint32_t ahead = begun_ + waiting_;
    if (ahead >= mostBegun) return false;
    if (!link_.rate()) return ahead + outstanding_ < unmeasured;
    if (outstanding_ >= ends_.size() + mostHeld) return false;
    if (static_cast<double>(link_.inFlight()) > mostInFlight()) return false;
    return std::max(link_.idleAt(), now) + linkTime(ahead * meanBytes_) <= now + duration(1e-3 * workMs_);
}

std::uint32_t FlowControl::begin(Clock::time_point now) {
    std::uint32_t count = 0;
    for (; mayBegin(now); ++begun_) ++count;
    return count;
}

std::optional<Clock::time_point> FlowControl::due(Clock::time_point now) const {
    if (!measured_ || link_.idleAt() <= now) return std::nullopt;
    const auto piece = link_.idleAt() - pieceTime;
    if (piece > now) return piece;
    const auto frame = link_.idleAt() + linkTime((begun_ + waiting_) * meanBytes_) - duration(1e-3 * workMs_);
    return std::max(frame, now + 1ms);
}

void FlowControl::made(std::size_t bytes, double workMs, bool quick) {
    MOTE_CHECK(begun_ > 0);
    --begun_;
    ++waiting_;
    if (!quick) return;
    const double size = static_cast<double>(bytes);
    meanBytes_ = meanBytes_ == 0.0 ? size : (1.0 - late) * meanBytes_ + late * size;
    workMs_ = (1.0 - late) * workMs_ + late * workMs;
}

void FlowControl::dropped(bool partlySent) {
    // A client may have returned what it has only a part of.
    if (partlySent) outstanding_ -= std::min(outstanding_, 1U);
    if (!partlySent) --waiting_;
}

std::size_t FlowControl::piece(Clock::time_point now, std::size_t begin, std::size_t left,
                               bool canWait) const {
    if (!measured_) return left;
    const auto rate = link_.rate();
    if (canWait && rate &&
        (link_.idleAt() > now + pieceTime || static_cast<double>(link_.inFlight()) > mostInFlight())) {
        return 0;
    }
    if (canWait && !rate && link_.inFlight() > 2 * leastPiece) return 0;
    const bool probe = begin == 0 && (!rate || linkTime(static_cast<double>(left)) > noProbe);
    if (probe) return std::min(left, probeBytes);
    if (!canWait) return left;
    const double most = rate ? *rate * Seconds(pieceTime).count() : 0.0;
    return most >= static_cast<double>(left)
               ? left
               : std::min(left, std::max(leastPiece, static_cast<std::size_t>(most)));
}

void FlowControl::sent(Clock::time_point now, std::size_t bytes, bool first, bool last) {
    if (first) {
        --waiting_;
        ++outstanding_;
    }
    if (!measured_) return;
    sentBytes_ += bytes;
    link_.sent(now, bytes);
    if (last) ends_.push_back(sentBytes_);
}

Status FlowControl::returned(Clock::time_point now, const proto::Credit& credit) {
    if (credit.frames() > outstanding_) {
        return Error{ErrorCode::invalidArgument, "credit.frames",
                     "more frames were returned than the server has sent"};
    }
    if (measured_ && credit.received_bytes() != 0) {
        if (!link_.received(now, credit.received_bytes())) {
            return Error{ErrorCode::invalidArgument, "credit.received_bytes",
                         "more was received than the server has sent, or less than before"};
        }
        while (!ends_.empty() && ends_.front() <= credit.received_bytes()) ends_.pop_front();
    }
    outstanding_ -= credit.frames();
    return success();
}

std::optional<std::size_t> FlowControl::frameBytes() const {
    const auto rate = link_.rate();
    if (!measured_ || !rate) return std::nullopt;
    return static_cast<std::size_t>(share * *rate / frameRate);
}

}  // namespace mote::server
