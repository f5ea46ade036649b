// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/progress_bar.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <string>

namespace mote::client {
namespace {

constexpr const char* wipe = "\r\x1b[K";

std::string remaining(std::chrono::duration<double> elapsed, std::size_t done, std::size_t total) {
    if (done == 0) return "";
    const auto seconds = static_cast<long>(
        elapsed.count() * static_cast<double>(total - done) / static_cast<double>(done) + 0.5);
    if (seconds < 60) return fmt::format(", {} s left", seconds);
    return fmt::format(", {} min {} s left", seconds / 60, seconds % 60);
}

}  // namespace

ProgressBar::ProgressBar(std::size_t total, bool wanted)
    : total_(total), visible_(wanted && total > 0 && ::isatty(STDERR_FILENO) == 1) {
    show(0);
}

ProgressBar::~ProgressBar() {
    if (visible_) std::fputs(wipe, stderr);
}

void ProgressBar::show(std::size_t done) {
    if (!visible_) return;
    constexpr std::size_t width = 30;
    const std::size_t filled = width * done / total_;
    const std::string bar = std::string(filled, '#') + std::string(width - filled, '.');
    const auto elapsed = std::chrono::steady_clock::now() - start_;
    fmt::print(stderr, "{}[{}] {} of {} frames{}", wipe, bar, done, total_, remaining(elapsed, done, total_));
    std::fflush(stderr);
}

}  // namespace mote::client
