// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/frame_report.h"

#include <fmt/format.h>

#include "client/frames/print_line.h"
#include "protocol/scene/json_string.h"

namespace mote::client {
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

}  // namespace mote::client
