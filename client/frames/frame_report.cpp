// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/frame_report.h"

#include <fmt/format.h>
#include <unistd.h>
#include <cstdio>

#include "protocol/base/json.h"
#include "protocol/base/json_string.h"
#include "protocol/base/utf8.h"
#include "protocol/mote.pb.h"

namespace mote::client {

Status print(const std::string& text) {
    if (std::fputs(text.c_str(), stdout) >= 0 && std::fflush(stdout) == 0) return success();
    return Error{ErrorCode::internal, "stdout", "cannot be written to any more"};
}

void FrameReport::add(const proto::Frame& message) {
    device = message.device();
    pointsDrawn += message.points_drawn();
    planMs += message.plan_ms();
    renderMs += message.render_ms();
    encodeMs += message.encode_ms();
}

std::string FrameReport::line() const {
    const std::chrono::duration<double, std::milli> total = std::chrono::steady_clock::now() - since;
    return fmt::format(
        "{{\"index\": {}, \"file\": {}, \"width\": {}, \"height\": {}, \"device\": {}, \"pointsDrawn\": {}, "
        "\"planMs\": {:.3f}, \"renderMs\": {:.3f}, \"encodeMs\": {:.3f}, \"totalMs\": {:.3f}}}\n",
        index, jsonString(file), width, height, jsonString(device), pointsDrawn, planMs, renderMs, encodeMs,
        total.count());
}

void ReportLines::expect(std::size_t index) {
    if (wanted_) lines_.emplace(index, std::nullopt);
}

Status ReportLines::say(const FrameReport& report) {
    if (!wanted_) return success();
    lines_[report.index] = report.line();
    return flush();
}

Status ReportLines::passOver(std::size_t index) {
    if (!wanted_) return success();
    lines_[index] = "";
    return flush();
}

Status ReportLines::flush() {
    while (!lines_.empty() && lines_.begin()->second) {
        const std::string line = *lines_.begin()->second;
        lines_.erase(lines_.begin());
        MOTE_RETURN_IF_ERROR(print(line));
    }
    return success();
}

namespace {

constexpr const char* wipe = "\r\x1b[K";
constexpr std::chrono::milliseconds tellEvery{200};

std::string remaining(std::chrono::duration<double> elapsed, std::size_t done, std::size_t left) {
    if (done == 0 || left == 0) return "";
    const auto seconds =
        static_cast<long>(elapsed.count() * static_cast<double>(left) / static_cast<double>(done) + 0.5);
    if (seconds < 60) return fmt::format(", {} s left", seconds);
    if (seconds < 3600) return fmt::format(", {} min {} s left", seconds / 60, seconds % 60);
    return fmt::format(", {} h {} min left", seconds / 3600, seconds / 60 % 60);
}

}  // namespace

ProgressBar::ProgressBar(bool wanted, int descriptor)
    : visible_(wanted && ::isatty(STDERR_FILENO) == 1), descriptor_(descriptor) {}

ProgressBar::~ProgressBar() {
    if (visible_ && shown_) std::fputs(wipe, stderr);
}

void ProgressBar::show(std::size_t done, std::size_t total, std::string_view phase) {
    if (total == 0) return;
    if (!shown_) first_ = done;
    if (visible_) draw(done, total, phase);
    if (descriptor_ >= 0) tell(done, total, phase);
    shown_ = true;
}

void ProgressBar::draw(std::size_t done, std::size_t total, std::string_view phase) {
    constexpr std::size_t width = 30;
    const std::size_t filled = width * done / total;
    const std::string bar = std::string(filled, '#') + std::string(width - filled, '.');
    const auto elapsed = std::chrono::steady_clock::now() - start_;
    fmt::print(stderr, "{}[{}] {} of {} frames{}{}", wipe, bar, done, total,
               remaining(elapsed, done - first_, total - done),
               phase.empty() ? "" : fmt::format(", {}", toTerminalText(phase)));
    std::fflush(stderr);
}

void ProgressBar::tell(std::size_t done, std::size_t total, std::string_view phase) {
    const auto now = std::chrono::steady_clock::now();
    if (shown_ && done != total && now - told_ < tellEvery) return;
    told_ = now;
    proto::JobProgress progress;
    progress.set_progress(static_cast<double>(done) / static_cast<double>(total));
    progress.set_phase(phase.empty() ? fmt::format("frame {} of {}", done, total) : std::string(phase));
    const auto line = toJsonLine(progress) + "\n";
    [[maybe_unused]] const auto written = ::write(descriptor_, line.data(), line.size());
}

}  // namespace mote::client
