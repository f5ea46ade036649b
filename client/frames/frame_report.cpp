// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/frame_report.h"

#include <fmt/format.h>

#include <string_view>

namespace mote::client {
namespace {

/// A JSON string. Bytes beyond ASCII are passed on as they are: names of files are UTF-8 nearly always.
std::string jsonString(std::string_view text) {
    std::string result = "\"";
    for (const char each : text) {
        if (each == '"' || each == '\\') {
            result += '\\';
            result += each;
        } else if (static_cast<unsigned char>(each) < 0x20) {
            result += fmt::format("\\u{:04x}", static_cast<unsigned>(each));
        } else {
            result += each;
        }
    }
    return result + '"';
}

}  // namespace

std::string FrameReport::toJson() const {
    return fmt::format(
        "{{\"index\": {}, \"file\": {}, \"width\": {}, \"height\": {}, \"device\": {}, \"pointsDrawn\": {}, "
        "\"planMs\": {:.3f}, \"renderMs\": {:.3f}, \"encodeMs\": {:.3f}, \"totalMs\": {:.3f}}}",
        index, jsonString(file), width, height, jsonString(device), pointsDrawn, planMs, renderMs, encodeMs,
        totalMs);
}

}  // namespace mote::client
