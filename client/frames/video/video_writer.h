// SPDX-License-Identifier: GPL-3.0-or-later
//
// VideoWriter: the frames of a film, in their order, into one file that appears whole by one rename. One
// owner, one thread at a time; the encoder has threads of its own, of a fixed number.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "client/frames/video/gif_palette.h"
#include "client/frames/video/video_settings.h"

namespace mote::client {

class VideoWriter {
  public:
    /// Begins a hidden file beside `path`; a file of that name is replaced at the end. GIF needs a palette.
    /// Errors: those of checkVideo; invalidArgument (a GIF without a palette); notFound, permissionDenied
    /// (the folder); alreadyExists (a folder of that name, or another process writes it);
    /// resourceExhausted.
    static Result<std::unique_ptr<VideoWriter>> create(const std::filesystem::path& path,
                                                       const VideoSettings& settings,
                                                       const std::optional<GifPalette>& palette = {});
    /// Unless it was finished, nothing stays.
    ~VideoWriter();
    VideoWriter(const VideoWriter&) = delete;
    VideoWriter& operator=(const VideoWriter&) = delete;

    /// The next frame: width x height x 4 bytes, RGBA, sRGB-encoded, row 0 on top; alpha is ignored. After
    /// an error nothing stays, and every call returns it. Errors: resourceExhausted (a full disk), those of
    /// the system, internal.
    Status add(std::span<const std::uint8_t> rgba);
    /// The film is there. Once, after the last frame. `key`: what it shows, for readVideoKey(); "": nobody
    /// asks. Errors: as of add; invalidArgument if there was no frame.
    Status finish(std::string_view key = {});

  private:
    class Impl;
    explicit VideoWriter(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
    Status state_ = success();  ///< the error that ended it
};

}  // namespace mote::client
