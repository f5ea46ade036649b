// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/video/video_settings.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>

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

namespace {

constexpr double leastFps = 0.01;  // 100 s a frame: GIF can wait 655 s, and nobody does

Error refused(std::string message) {
    return {ErrorCode::invalidArgument, "", std::move(message)};
}

Status checkSize(const VideoSettings& settings, const VideoCodec& codec) {
    const auto [width, height] = std::pair{settings.width, settings.height};
    const auto size = fmt::format("a film of {} x {} pixels cannot be {}", width, height, codec.title);
    if (width < codec.leastSide || height < codec.leastSide) {
        return refused(fmt::format("{}: each side has {} pixels at least", size, codec.leastSide));
    }
    if (width > codec.mostSide || height > codec.mostSide) {
        return refused(fmt::format("{}: each side has {} pixels at most", size, codec.mostSide));
    }
    if (std::uint64_t{width} * height > codec.mostPixels) {
        return refused(fmt::format("{}: it has {} pixels at most", size, codec.mostPixels));
    }
    if (codec.evenSides && (width % 2 != 0 || height % 2 != 0)) {
        return refused(fmt::format("{}: both sides must be even", size));
    }
    return success();
}

Status checkRate(double fps, const VideoCodec& codec) {
    if (std::isfinite(fps) && fps >= leastFps && fps <= codec.mostFps) return success();
    return refused(
        fmt::format("{} has {} to {} frames a second, not {}", codec.title, leastFps, codec.mostFps, fps));
}

Status checkQuality(const std::optional<unsigned>& quality, const VideoCodec& codec) {
    if (!quality) return success();
    if (!codec.mostCrf) return refused(fmt::format("{} takes no crf", codec.title));
    if (*quality <= *codec.mostCrf) return success();
    return refused(fmt::format("{} takes a crf of 0 to {}, not {}", codec.title, *codec.mostCrf, *quality));
}

}  // namespace

std::optional<VideoFormat> videoFormat(std::string_view extension) {
    if (extension.starts_with('.')) extension.remove_prefix(1);
    std::string lower(extension);
    std::transform(lower.begin(), lower.end(), lower.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    for (const auto format : {VideoFormat::mp4, VideoFormat::webm, VideoFormat::gif}) {
        if (videoCodec(format).container == lower) return format;
    }
    return std::nullopt;
}

Result<VideoFormat> videoFormatOf(const std::filesystem::path& file) {
    if (const auto format = videoFormat(file.extension().string())) return *format;
    return invalid("--video",
                   fmt::format("\"{}\" is no video: FILE.mp4, FILE.webm or FILE.gif", file.string()));
}

std::string_view name(VideoFormat format) {
    return videoCodec(format).title;
}

unsigned defaultQuality(VideoFormat format) {
    return videoCodec(format).defaultCrf;
}

Status checkVideo(const VideoSettings& settings) {
    const auto& codec = videoCodec(settings.format);
    MOTE_RETURN_IF_ERROR(checkSize(settings, codec));
    MOTE_RETURN_IF_ERROR(checkRate(settings.fps, codec));
    MOTE_RETURN_IF_ERROR(checkQuality(settings.quality, codec));
    if (!avcodec_find_encoder_by_name(codec.encoder)) {
        return Error{
            ErrorCode::unsupported, "",
            fmt::format("libavcodec has no {} here, which {} films need", codec.encoder, codec.title)};
    }
    if (!av_guess_format(codec.container, nullptr, nullptr)) {
        return Error{ErrorCode::unsupported, "",
                     fmt::format("libavformat cannot write {} films here", codec.title)};
    }
    return success();
}

namespace {

constexpr std::size_t keySize = 32;

}  // namespace

std::string videoTail(VideoFormat format, std::string_view key) {
    auto text = fmt::format("mote-frames {}\n", key);
    switch (format) {
        case VideoFormat::mp4: {
            const std::size_t size = 8 + text.size();  // of the whole box, four bytes, then its kind
            return std::string{'\0', '\0', '\0', static_cast<char>(size)} + "free" + text;
        }
        case VideoFormat::webm:
            // The element's number, then its size in one byte, which is marked by its highest bit.
            return std::string{'\xec', static_cast<char>(0x80 | text.size())} + text;
        case VideoFormat::gif:
            return text;
    }
    return text;
}

std::optional<std::string> readVideoKey(const std::filesystem::path& path, VideoFormat format) {
    const auto size = static_cast<std::streamoff>(videoTail(format, std::string(keySize, '0')).size());
    std::ifstream file(path, std::ios::binary);
    file.seekg(-size, std::ios::end);
    std::string tail(static_cast<std::size_t>(size), '\0');
    file.read(tail.data(), size);
    if (!file.good()) return std::nullopt;
    auto key = tail.substr(tail.size() - 1 - keySize, keySize);
    if (videoTail(format, key) != tail) return std::nullopt;
    return key;
}

}  // namespace mote::client
