// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/session/parked_sessions.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "protocol/wire/framing.h"
#include "server/session/token.h"

namespace mote::server {
namespace {

void append(std::vector<std::uint8_t>& bytes, const proto::ClientMessage& message) {
    std::vector<std::uint8_t> frame;
    // What a client could say fits.
    if (wire::encodeFrame(message, 0, wire::clientLimits, frame).ok()) {
        bytes.insert(bytes.end(), frame.begin(), frame.end());
    }
}

/// Takes one message from the front.
Result<proto::ClientMessage> takeMessage(std::span<const std::uint8_t>& bytes) {
    wire::Header header{};
    proto::ClientMessage message;
    if (bytes.size() < header.size())
        return Error{ErrorCode::corrupt, "", "it ends in the midst of a message"};
    std::copy_n(bytes.begin(), header.size(), header.begin());
    MOTE_ASSIGN_OR_RETURN(const auto lengths, wire::decodeHeader(header, wire::clientLimits));
    bytes = bytes.subspan(header.size());
    if (bytes.size() < lengths.message)
        return Error{ErrorCode::corrupt, "", "it ends in the midst of a message"};
    MOTE_RETURN_IF_ERROR(wire::decodeMessage(bytes.first(lengths.message), message));
    bytes = bytes.subspan(lengths.message);
    return message;
}

}  // namespace

ParkedSessions::Entry* ParkedSessions::find(SessionId session) {
    const auto found = std::find_if(entries_.begin(), entries_.end(),
                                    [&](const Entry& entry) { return entry.session == session; });
    return found == entries_.end() ? nullptr : &*found;
}

/// Looks at all of them wherever the right one is.
const ParkedSessions::Entry* ParkedSessions::find(std::string_view secret) const {
    const Entry* found = nullptr;
    for (const auto& entry : entries_) {
        const bool now = sameToken(entry.secret, secret), before = sameToken(entry.before, secret);
        if (now || before) found = &entry;
    }
    return found;
}

std::optional<SessionId> ParkedSessions::sessionOf(std::string_view secret) const {
    const auto* const entry = find(secret);
    return entry == nullptr ? std::nullopt : std::optional(entry->session);
}

ParkedSessions::Admission ParkedSessions::admit(std::string_view secret, SessionId session, Time now) {
    forgetOld(now);
    Admission admission{.secret = makeToken()};
    if (const auto* const known = find(secret)) {
        auto& entry = entries_[static_cast<std::size_t>(known - entries_.data())];
        admission.resumed = true;
        admission.before = std::exchange(entry.session, session);
        admission.state = entry.state;
        entry.before = secret;
        entry.secret = admission.secret;
        entry.left.reset();
    } else {
        entries_.push_back({.session = session, .secret = admission.secret});
        if (entries_.size() > limits_.number) forgetOne(session);
    }
    changed_();
    return admission;
}

void ParkedSessions::confirm(SessionId session) {
    auto* const entry = find(session);
    if (entry != nullptr) entry->before.clear();
}

void ParkedSessions::setView(SessionId session, const proto::SetView& view) {
    auto* entry = find(session);
    if (entry == nullptr) return;
    entry->state.view = view;
    entry->bytes = view.ByteSizeLong();
    while (bytes() > limits_.bytes && forgetOne(session)) entry = find(session);
    if (bytes() > limits_.bytes) {
        entry->state.view.reset();
        entry->bytes = 0;
    }
    changed_();
}

void ParkedSessions::watchJobs(SessionId session) {
    auto* const entry = find(session);
    if (entry == nullptr || std::exchange(entry->state.watchesJobs, true)) return;
    changed_();
}

void ParkedSessions::left(SessionId session, Time now) {
    auto* const entry = find(session);
    if (entry != nullptr) entry->left = now;
    sweepUploads(now);
}

void ParkedSessions::setUploads(SessionId session, std::shared_ptr<Uploads> uploads) {
    auto* const entry = find(session);
    if (entry != nullptr) entry->state.uploads = std::move(uploads);
}

void ParkedSessions::sweepUploads(Time now) {
    std::uint64_t sum = 0;
    for (auto& entry : entries_) {
        if (!entry.left || !entry.state.uploads) continue;
        if (now - *entry.left >= limits_.uploadsKept) {
            entry.state.uploads.reset();
        } else {
            sum += entry.state.uploads->bytes();
        }
    }
    while (sum > limits_.uploadBytes) {
        const auto gone = std::exchange(firstThatLeft(0, true)->state.uploads, nullptr);
        sum -= std::min(sum, gone->bytes());
    }
}

void ParkedSessions::forgetOld(Time now) {
    std::erase_if(entries_,
                  [&](const Entry& entry) { return entry.left && now - *entry.left > limits_.kept; });
}

/// Null where all others are connected. `keep` 0: none.
ParkedSessions::Entry* ParkedSessions::firstThatLeft(SessionId keep, bool withUploads) {
    Entry* first = nullptr;
    for (auto& entry : entries_) {
        if (!entry.left || (keep != 0 && entry.session == keep)) continue;
        if (withUploads && !entry.state.uploads) continue;
        if (first == nullptr || *entry.left < *first->left) first = &entry;
    }
    return first;
}

/// The one that left first. False where all others are connected.
bool ParkedSessions::forgetOne(SessionId keep) {
    const auto* const first = firstThatLeft(keep, false);
    if (first == nullptr) return false;
    entries_.erase(entries_.begin() + (first - entries_.data()));
    return true;
}

std::size_t ParkedSessions::bytes() const {
    return std::accumulate(entries_.begin(), entries_.end(), std::size_t{0},
                           [](std::size_t sum, const Entry& entry) { return sum + entry.bytes; });
}

std::vector<std::uint8_t> ParkedSessions::toBytes() const {
    std::vector<std::uint8_t> bytes;
    for (const auto& entry : entries_) {
        proto::ClientMessage hello, view, jobs;
        hello.mutable_hello()->set_resume(entry.secret);
        append(bytes, hello);
        if (entry.state.view) {
            *view.mutable_set_view() = *entry.state.view;
            append(bytes, view);
        }
        jobs.mutable_watch_jobs();
        if (entry.state.watchesJobs) append(bytes, jobs);
    }
    return bytes;
}

Status ParkedSessions::add(std::span<const std::uint8_t> bytes, Time now) {
    while (!bytes.empty() && entries_.size() < limits_.number) {
        MOTE_ASSIGN_OR_RETURN(auto message, takeMessage(bytes));
        if (message.has_hello()) {
            entries_.push_back({.secret = message.hello().resume(), .left = now});
        } else if (entries_.empty()) {
            return Error{ErrorCode::corrupt, "", "it begins with no session"};
        } else if (message.has_watch_jobs()) {
            entries_.back().state.watchesJobs = true;
        } else if (message.has_set_view()) {
            entries_.back().bytes = message.set_view().ByteSizeLong();
            entries_.back().state.view = std::move(*message.mutable_set_view());
        }
    }
    return success();
}

}  // namespace mote::server
