// SPDX-License-Identifier: GPL-3.0-or-later
//
// What each format of films is made by, and what it can hold: one table for the check before a film and for
// its making. Constants, any thread.
#pragma once

#include <cstdint>
#include <optional>

#include "client/frames/video/video_settings.h"

namespace mote::client {

struct VideoCodec {
    const char* container;              ///< libavformat's name; also the file's extension
    const char* title;                  ///< for sentences
    const char* encoder;                ///< libavcodec's name
    std::uint32_t leastSide, mostSide;  ///< pixels
    std::uint64_t mostPixels;           ///< of a frame
    bool evenSides;                     ///< odd ones are refused: nothing is resized
    double mostFps;                     ///< frames a second
    std::optional<unsigned> mostCrf;    ///< 0 to this; none: no such thing
    unsigned defaultCrf;
};

const VideoCodec& videoCodec(VideoFormat format);

}  // namespace mote::client
