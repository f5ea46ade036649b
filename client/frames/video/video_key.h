// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a finished video shows, as a key of 32 hexadecimal digits at its end, where players look for nothing:
// in a free box of an MP4, a void element of a WebM, behind the end of a GIF. Pure, but for the file.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "client/frames/video/video_settings.h"

namespace mote::client {

/// The bytes to be appended.
std::string videoTail(VideoFormat format, std::string_view key);

/// The key of a video that mote-frames made; empty where there is none.
std::optional<std::string> readVideoKey(const std::filesystem::path& path, VideoFormat format);

}  // namespace mote::client
