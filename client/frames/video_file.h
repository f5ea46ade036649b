// SPDX-License-Identifier: GPL-3.0-or-later
//
// VideoFile: the frames of a run as one video. Each is kept whole beside it (FrameStore) until the video is
// there, and encoded in its turn by a thread, while later ones are drawn. See frame_sink.h.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "client/frames/frame_sink.h"
#include "client/frames/frame_store.h"
#include "client/frames/video/video_settings.h"
#include "client/shared/decode.h"
#include "protocol/base/error.h"

namespace mote::client {

/// Gives frame `index`; asked for in ascending order. SRGB8.
using FrameReader = std::function<Result<FramePixels>(std::size_t index)>;

/// The video appears by one rename; `key` says what it shows, for readVideoKey(). Errors: the reader's,
/// corrupt (a frame of another size), VideoWriter's.
Status videoOfFrames(const std::filesystem::path& path, const VideoSettings& settings, std::size_t count,
                     const FrameReader& frame, std::string_view key = {});

class VideoFile final : public FrameSink {
  public:
    /// `key`: of the whole film, 32 hexadecimal digits, which the video keeps; `pictures`: also gets each
    /// frame; may be null.
    VideoFile(std::filesystem::path path, VideoSettings settings, std::size_t frames, std::string key,
              std::unique_ptr<FrameSink> pictures);
    /// What is not finished is given up; the frames stay.
    ~VideoFile() override;

    Status open(bool resume) override;
    bool has(std::size_t index, std::string_view key, std::uint32_t width,
             std::uint32_t height) const override;
    void there(std::size_t index) override;
    Status put(DrawnFrame frame) override;
    std::size_t backlog() const override;
    Status finish(const std::function<bool(std::size_t)>& goOn) override;
    std::filesystem::path fileOf(std::size_t index) const override;
    std::string kept() const override;

  private:
    void encodeAll();
    Result<FramePixels> inTurn(std::size_t index);

    const std::filesystem::path path_;
    const VideoSettings settings_;
    const std::string key_;
    const std::unique_ptr<FrameSink> pictures_;
    FrameStore store_;

    mutable std::mutex mutex_;
    std::condition_variable changed_;
    // Under the mutex.
    std::vector<bool> stored_;
    std::map<std::size_t, FramePixels> waiting_;  // stored ones that need not be read again
    std::size_t through_ = 0;
    std::optional<Status> outcome_;
    bool ending_ = false;

    std::thread thread_;
};

}  // namespace mote::client
