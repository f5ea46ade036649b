// SPDX-License-Identifier: GPL-3.0-or-later
//
// FrameSink: where the frames of a run go: picture files (PictureFiles), or a video (VideoFile). put() and
// has() may be called from several threads at a time, for different frames; all else by the owner.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "client/frames/picture_file.h"
#include "client/shared/decode.h"
#include "protocol/base/error.h"

namespace mote::client {

/// A frame as it is to be kept.
struct DrawnFrame {
    std::size_t index = 0;
    std::string key;  ///< of what it shows, hexadecimal digits
    FramePixels pixels;
    std::vector<std::uint8_t> payload;  ///< the lossless frame as it travelled; empty if it was averaged
};

class FrameSink {
  public:
    virtual ~FrameSink() = default;
    /// Comes before any frame; what an earlier run left is kept if `resume`. Errors: the folder's.
    virtual Status open(bool resume) = 0;
    /// Tells whether a frame of that key and size stands already.
    virtual bool has(std::size_t index, std::string_view key, std::uint32_t width,
                     std::uint32_t height) const = 0;
    /// A frame for which has() held is to stay as it is.
    virtual void there(std::size_t) {}
    /// Errors: the disk's, with the file's name; of a frame that cannot be encoded.
    virtual Status put(DrawnFrame frame) = 0;
    /// Frames that were put and are not through with yet: more should wait.
    virtual std::size_t backlog() const = 0;
    /// Makes, once all frames are there, what is made of all of them. `goOn` is called with how many frames
    /// are through, and says whether to go on. Errors: cancelled, the disk's.
    virtual Status finish(const std::function<bool(std::size_t done)>& goOn) = 0;
    /// What a frame becomes, or becomes part of.
    virtual std::filesystem::path fileOf(std::size_t index) const = 0;
    /// What is kept of a run that stopped and how to go on, one sentence; empty if there is nothing to
    /// say.
    virtual std::string kept() const { return {}; }
};

/// The key of a picture or a film, by which --resume knows its own: 32 hexadecimal digits, of a text that
/// holds all that decides the bytes. Pure; any thread.
std::string keyOf(std::string_view text);

/// Each frame as a file of a folder, DIR/frame-000000.EXT.
class PictureFiles final : public FrameSink {
  public:
    PictureFiles(std::filesystem::path folder, PictureFormat format)
        : folder_(std::move(folder)), format_(format) {}
    /// Takes the folder away where it was made and nothing came to lie in it.
    ~PictureFiles() override;

    Status open(bool resume) override;
    bool has(std::size_t index, std::string_view key, std::uint32_t width,
             std::uint32_t height) const override;
    Status put(DrawnFrame frame) override;
    std::size_t backlog() const override { return 0; }
    Status finish(const std::function<bool(std::size_t)>&) override { return success(); }
    std::filesystem::path fileOf(std::size_t index) const override;

  private:
    std::filesystem::path folder_;
    PictureFormat format_;
    bool made_ = false;
};

/// Lowers the priority of the thread that calls it, and of those that it starts: who draws the next frames on
/// this machine goes before those who pack the last. It stays high enough that whoever waits for one of its
/// locks does not wait long.
void giveWayToDrawing();

/// A few threads that hand frames to a sink while the next ones are drawn, and give way to who draws them.
/// One owner; its `wake` is called by the threads.
class FinishingThreads {
  public:
    /// The sink outlives it. `wake`: something was finished.
    FinishingThreads(FrameSink& sink, unsigned threads, std::function<void()> wake);
    /// Waits for what is under way and drops the rest.
    ~FinishingThreads();
    FinishingThreads(const FinishingThreads&) = delete;
    FinishingThreads& operator=(const FinishingThreads&) = delete;

    void post(DrawnFrame frame);
    /// The frames that were finished since the last call. Errors: why the first frame of the film, among
    /// those under way, could not be; nothing is to be posted after it.
    Result<std::vector<std::size_t>> take();
    /// Frames that were posted and not taken.
    std::size_t open() const { return open_; }

  private:
    struct Finished {
        std::size_t index = 0;
        Status status = success();
    };

    void work();
    void end();

    FrameSink& sink_;
    const std::function<void()> wake_;
    std::size_t open_ = 0;  // the owner's

    std::mutex mutex_;
    std::condition_variable changed_;
    // Under the mutex.
    std::deque<DrawnFrame> waiting_;
    std::vector<Finished> finished_;
    bool ending_ = false;

    std::vector<std::thread> threads_;
};

}  // namespace mote::client
