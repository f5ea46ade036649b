// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/video/video_codec.h"

#include <array>

namespace mote::client {
namespace {

constexpr std::uint64_t mostPixels = 35'651'584;  // H.264's highest level, 6.2
constexpr double millisecond = 1000;              // WebM counts time in them

/// In the order of VideoFormat. A GIF's wait is in hundredths of a second, and viewers take one of a single
/// hundredth for ten.
constexpr std::array<VideoCodec, 3> codecs{
    {{"mp4", "MP4", "libx264", 2, 16384, mostPixels, true, 1000, 51, 16},
     {"webm", "WebM", "libvpx-vp9", 2, 16384, mostPixels, true, millisecond, 63, 8},
     {"gif", "GIF", "gif", 1, 65535, mostPixels, false, 50, std::nullopt, 0}}};

}  // namespace

const VideoCodec& videoCodec(VideoFormat format) {
    return codecs.at(static_cast<std::size_t>(format));
}

}  // namespace mote::client
