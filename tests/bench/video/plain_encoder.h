// SPDX-License-Identifier: GPL-3.0-or-later
//
// One encoder of libavcodec with options of one's own, into an MP4 or WebM file: what client/frames/video is
// chosen from. One thread. Throws std::runtime_error.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "client/frames/video/video_settings.h"

namespace mote::bench {

using Frames = std::vector<std::vector<std::uint8_t>>;

/// `options` as libav has them: "preset=medium:crf=18". Returns seconds of processor time, of all threads.
double encodePlainly(const std::filesystem::path& file, const client::VideoSettings& settings,
                     const std::string& encoder, const std::string& options, const Frames& frames);

/// Of this process, seconds.
double processorTime();

}  // namespace mote::bench
