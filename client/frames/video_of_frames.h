// SPDX-License-Identifier: GPL-3.0-or-later
//
// Makes a video of frames that are read one after the other; of a GIF twice, as its colours are chosen from
// all of them. Any thread.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string_view>

#include "client/frames/video/video_settings.h"
#include "client/shared/decode.h"
#include "protocol/scene/error.h"

namespace mote::client {

/// Gives frame `index`; asked for in ascending order. SRGB8.
using FrameReader = std::function<Result<FramePixels>(std::size_t index)>;

/// The video appears by one rename; `key` says what it shows, for readVideoKey(). Errors: the reader's,
/// corrupt (a frame of another size), VideoWriter's.
Status videoOfFrames(const std::filesystem::path& path, const VideoSettings& settings, std::size_t count,
                     const FrameReader& frame, std::string_view key = {});

/// A picture file that mote-frames wrote, as a frame. Errors: notFound, corrupt, unsupported (linear pixels).
Result<FramePixels> readPictureFrame(const std::filesystem::path& path);

}  // namespace mote::client
