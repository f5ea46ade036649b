// SPDX-License-Identifier: GPL-3.0-or-later
//
// FrameReport: what is said of a finished frame with --json. A value.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace mote::client {

struct FrameReport {
    std::size_t index = 0;     ///< of the view in the script
    std::string file;          ///< of the picture
    std::uint32_t width = 0;   ///< pixels
    std::uint32_t height = 0;  ///< pixels
    std::string device;        ///< that drew it
    std::uint64_t pointsDrawn = 0;
    double planMs = 0.0;    ///< on the server
    double renderMs = 0.0;  ///< on the server
    double encodeMs = 0.0;  ///< on the server, for the way here
    double totalMs = 0.0;   ///< from sending the view to the finished file

    /// One JSON object on one line, without its end.
    std::string toJson() const;
};

}  // namespace mote::client
