// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a film's file is: its container and codec, size, rate, quality. Values and pure functions, any thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "protocol/base/error.h"

namespace mote::client {

enum class VideoFormat {
    mp4,   ///< H.264 by libx264
    webm,  ///< VP9 by libvpx
    gif,   ///< at most 255 colours, the film's own
};

/// How many samples of colour an MP4 or WebM film has. Full: one a pixel, what dots of one pixel need, but
/// some players do not know it. Halved: one for two by two pixels, for every player.
enum class VideoChroma { full, halved };

struct VideoSettings {
    VideoFormat format = VideoFormat::mp4;
    std::uint32_t width = 0;          ///< pixels
    std::uint32_t height = 0;         ///< pixels
    double fps = 30;                  ///< frames a second
    std::optional<unsigned> quality;  ///< the codec's constant rate factor, less is better; without: good
    VideoChroma chroma = VideoChroma::full;
};

/// "mp4", "webm" or "gif", with or without a dot before it, in either case.
std::optional<VideoFormat> videoFormat(std::string_view extension);

/// That of a file by its name. Errors: invalidArgument (--video: it does not end in .mp4, .webm or .gif).
Result<VideoFormat> videoFormatOf(const std::filesystem::path& file);

/// "MP4", "WebM", "GIF": for sentences.
std::string_view name(VideoFormat format);

/// The constant rate factor that is used if none is given; 0 for GIF, which has none.
unsigned defaultQuality(VideoFormat format);

/// Checks that such a film can be made here, before anything is drawn. Errors: invalidArgument (a size, rate
/// or quality that the format cannot hold), unsupported (libavcodec has no such encoder).
Status checkVideo(const VideoSettings& settings);

/// What a format of films is made by, and what it can hold: for the check before a film and for its making.
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

// What a finished video shows, as a key of 32 hexadecimal digits at its end, where players look for nothing:
// in a free box of an MP4, a void element of a WebM, behind the end of a GIF. Pure, but for the file.

/// The bytes to be appended.
std::string videoTail(VideoFormat format, std::string_view key);

/// The key of a video that mote-frames made; empty if there is none.
std::optional<std::string> readVideoKey(const std::filesystem::path& path, VideoFormat format);

}  // namespace mote::client
