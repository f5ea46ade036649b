// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/console_progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "protocol/mote.pb.h"
#include "protocol/scene/json.h"

namespace mote::prep {

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
    fmt::print(stderr, "mote-prep: {}\n", sentence);
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
    fmt::print(stderr, "\r\x1b[K[{:#<{}}{:.<{}}] {:3}% {}", "", full, "", width - full, percent_, phase_);
    std::fflush(stderr);
}

void ConsoleProgress::clearBar() const {
    if (bar_ && percent_ >= 0) fmt::print(stderr, "\r\x1b[K");
}

}  // namespace mote::prep
