// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/session/startups.h"

#include <algorithm>
#include <random>
#include <utility>

#include "server/log.h"
#include "server/session/outbox.h"

namespace mote::server {
namespace {

Error tooMany() {
    return {ErrorCode::resourceExhausted, "server",
            "too many connections that have shown no token are there; try again"};
}

}  // namespace

StartupRandom uniformRandom() {
    return [generator = std::mt19937_64(std::random_device()())]() mutable {
        return std::uniform_real_distribution<double>(0.0, 1.0)(generator);
    };
}

double StartupLimits::dropped(std::size_t pending) const {
    if (pending < start) return 0.0;
    if (pending >= full) return 1.0;
    return rate + (1.0 - rate) * static_cast<double>(pending - start) / static_cast<double>(full - start);
}

Startups::Startups(StartupLimits limits, Random random, FailureDelay delay, HandshakeTerms terms,
                   Metrics& metrics)
    : limits_(limits),
      random_(std::move(random)),
      terms_(std::move(terms)),
      metrics_(metrics),
      delay_(delay) {
    terms_.wrongToken = [this] {
        metrics_.refusedToken.add();
        log::warn("a client was refused: no hello with the right token");
        return delay_.next(std::chrono::steady_clock::now());
    };
    terms_.ended = [this](const Handshake& handshake) { erase(handshake); };
}

void Startups::add(wire::MessageStream stream) {
    if (random_() < limits_.dropped(pending_.size()) && dropOne(stream)) return;
    auto handshake = std::make_shared<Handshake>(std::move(stream), terms_);
    pending_.push_back(handshake);
    handshake->start();
}

bool Startups::dropOne(wire::MessageStream& newcomer) {
    metrics_.refusedStartup.add();
    log::warn("{} connections have shown no token; one was dropped", pending_.size());
    const auto places = static_cast<double>(pending_.size() + 1);
    const auto place = static_cast<std::size_t>(random_() * places);
    if (place >= pending_.size()) {
        newcomer.turnAway(failureMessage(0, tooMany(), true));
        return true;
    }
    const auto unlucky = pending_[place];  // it leaves the list
    unlucky->drop(tooMany());
    return false;
}

void Startups::erase(const Handshake& handshake) {
    const auto found = std::find_if(pending_.begin(), pending_.end(),
                                    [&](const auto& other) { return other.get() == &handshake; });
    if (found == pending_.end()) return;
    std::swap(*found, pending_.back());
    pending_.pop_back();
}

void Startups::stop() {
    for (const auto& handshake : std::exchange(pending_, {}))
        handshake->drop({ErrorCode::cancelled, "server", "the server ends"});
}

}  // namespace mote::server
