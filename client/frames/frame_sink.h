// SPDX-License-Identifier: GPL-3.0-or-later
//
// FrameSink: where the frames of a run go: picture files (PictureFiles), or a video (VideoFile). put() and
// has() may be called from several threads at a time, for different frames; all else by the owner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "client/shared/decode.h"
#include "protocol/scene/error.h"

namespace mote::client {

/// A frame as it is to be kept.
struct DrawnFrame {
    std::size_t index = 0;
    std::string key;  ///< of what it shows, hexadecimal digits
    FramePixels pixels;
    std::vector<std::uint8_t> payload;  ///< the lossless frame as it travelled; empty where it was averaged
};

class FrameSink {
  public:
    virtual ~FrameSink() = default;
    /// Before any frame; what an earlier run left is kept where `resume`. Errors: the folder's.
    virtual Status open(bool resume) = 0;
    /// Whether a frame of that key and size stands already.
    virtual bool has(std::size_t index, std::string_view key, std::uint32_t width,
                     std::uint32_t height) const = 0;
    /// A frame for which has() held is to stay as it is.
    virtual void there(std::size_t) {}
    /// Errors: the disk's, with the file's name; of a frame that cannot be encoded.
    virtual Status put(DrawnFrame frame) = 0;
    /// Frames that were put and are not through with yet: more should wait.
    virtual std::size_t backlog() const = 0;
    /// All frames are there: makes what is made of all of them. `goOn` is called with how many frames are
    /// through, and says whether to go on. Errors: cancelled, the disk's.
    virtual Status finish(const std::function<bool(std::size_t done)>& goOn) = 0;
    /// What a frame becomes, or becomes part of.
    virtual std::filesystem::path fileOf(std::size_t index) const = 0;
    /// What is kept of a run that stopped and how to go on, one sentence; empty where there is nothing to
    /// say.
    virtual std::string kept() const { return {}; }
};

}  // namespace mote::client
