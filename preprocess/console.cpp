// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/console.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>

#include "protocol/base/complain.h"
#include "protocol/base/json.h"
#include "protocol/base/json_string.h"
#include "protocol/base/utf8.h"
#include "protocol/mote.pb.h"

namespace mote::prep {
namespace {

// A signal handler reaches nothing but what is static.
std::atomic<int> receivedSignal{0};
static_assert(std::atomic<int>::is_always_lock_free);

extern "C" void onSignal(int number) {
    receivedSignal.store(number, std::memory_order_relaxed);
}

}  // namespace

JsonObject& JsonObject::addRaw(std::string_view name, std::string_view json) {
    members_ += fmt::format("{}{}: {}", members_.empty() ? "" : ", ", jsonString(name), json);
    return *this;
}

JsonObject& JsonObject::add(std::string_view name, std::string_view text) {
    return addRaw(name, jsonString(text));
}

JsonObject& JsonObject::add(std::string_view name, bool value) {
    return addRaw(name, value ? "true" : "false");
}

JsonObject& JsonObject::add(std::string_view name, double number) {
    return addRaw(name, fmt::format("{}", number));
}

JsonObject& JsonObject::add(std::string_view name, const std::vector<JsonObject>& objects) {
    std::string list;
    for (const auto& object : objects) list += (list.empty() ? "" : ", ") + object.text();
    return addRaw(name, "[" + list + "]");
}

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

ConsoleProgress::ConsoleProgress(const CancelSignal& signal, Options options)
    : signal_(signal), options_(options), bar_(!options.quiet && ::isatty(STDERR_FILENO) == 1) {}

ConsoleProgress::~ConsoleProgress() {
    clearBar();
}

void ConsoleProgress::report(double fraction, std::string_view phase) {
    const std::lock_guard lock(mutex_);
    fraction_ = std::clamp(fraction, fraction_, 1.0);
    const int percent = static_cast<int>(100.0 * fraction_);
    if (percent == percent_ && phase == phase_) return;
    percent_ = percent;
    phase_ = phase;
    writeLine();
    drawBar();
}

void ConsoleProgress::note(std::string_view sentence) {
    if (options_.quiet) return;
    const std::lock_guard lock(mutex_);
    clearBar();
    complain("mote-prep", sentence);
    drawBar();
}

void ConsoleProgress::writeLine() {
    if (options_.lineDescriptor < 0) return;
    proto::JobProgress message;
    message.set_progress(fraction_);
    message.set_phase(phase_);
    const std::string line = toJsonLine(message, true) + "\n";
    // Whoever listened may be gone; the job goes on without.
    if (::write(options_.lineDescriptor, line.data(), line.size()) < 0) options_.lineDescriptor = -1;
}

void ConsoleProgress::drawBar() const {
    if (!bar_ || percent_ < 0) return;
    constexpr int width = 30;
    const int full = percent_ * width / 100;
    fmt::print(stderr, "\r\x1b[K[{:#<{}}{:.<{}}] {:3}% {}", "", full, "", width - full, percent_,
               toTerminalText(phase_));
    std::fflush(stderr);
}

void ConsoleProgress::clearBar() const {
    if (bar_ && percent_ >= 0) fmt::print(stderr, "\r\x1b[K");
}

}  // namespace mote::prep
