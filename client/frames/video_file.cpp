// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/video_file.h"

#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <exception>
#include <optional>

#include "client/frames/exposure.h"
#include "client/frames/video/gif_palette.h"
#include "client/frames/video/video_writer.h"

namespace mote::client {
namespace {

Result<FramePixels> checkedFrame(const FrameReader& frame, std::size_t index, const VideoSettings& settings) {
    auto pixels = frame(index);
    if (!pixels.ok()) return pixels;
    if (pixels->width == settings.width && pixels->height == settings.height) return pixels;
    return Error{ErrorCode::corrupt, fmt::format("frame {}", index),
                 fmt::format("has {} x {} pixels, and the video {} x {}", pixels->width, pixels->height,
                             settings.width, settings.height)};
}

}  // namespace

Status videoOfFrames(const std::filesystem::path& path, const VideoSettings& settings, std::size_t count,
                     const FrameReader& frame, std::string_view key) {
    std::optional<GifPalette> palette;
    if (settings.format == VideoFormat::gif) {
        PaletteMaker maker;
        for (std::size_t i = 0; i < count; ++i) {
            MOTE_ASSIGN_OR_RETURN(const auto pixels, checkedFrame(frame, i, settings));
            maker.add(pixels.bytes);
        }
        palette = maker.make();
    }
    MOTE_ASSIGN_OR_RETURN(const auto writer, VideoWriter::create(path, settings, palette));
    for (std::size_t i = 0; i < count; ++i) {
        MOTE_ASSIGN_OR_RETURN(const auto pixels, checkedFrame(frame, i, settings));
        MOTE_RETURN_IF_ERROR(writer->add(pixels.bytes));
    }
    return writer->finish(key);
}

namespace {

/// Frames that wait in memory for their turn; those beyond are read again.
constexpr std::size_t mostWaiting = 4;
constexpr std::chrono::milliseconds patience{50};

}  // namespace

VideoFile::VideoFile(std::filesystem::path path, VideoSettings settings, std::size_t frames, std::string key,
                     std::unique_ptr<FrameSink> pictures)
    : path_(std::move(path)),
      settings_(std::move(settings)),
      key_(std::move(key)),
      pictures_(std::move(pictures)),
      store_(path_),
      stored_(frames, false) {}

VideoFile::~VideoFile() {
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
    std::error_code ignored;
    std::filesystem::remove(store_.folder(), ignored);  // fails where there is a frame: as it should
}

Status VideoFile::open(bool resume) {
    std::error_code code;
    if (std::filesystem::is_directory(path_, code))
        return Error{ErrorCode::alreadyExists, path_.string(), "is a folder"};
    MOTE_RETURN_IF_ERROR(store_.open(resume));
    if (pictures_) MOTE_RETURN_IF_ERROR(pictures_->open(resume));
    thread_ = std::thread([this] { encodeAll(); });
    return success();
}

bool VideoFile::has(std::size_t index, std::string_view key, std::uint32_t width,
                    std::uint32_t height) const {
    return store_.has(index, key) && (!pictures_ || pictures_->has(index, key, width, height));
}

void VideoFile::there(std::size_t index) {
    {
        const std::lock_guard lock(mutex_);
        stored_[index] = true;
    }
    changed_.notify_all();
}

Status VideoFile::put(DrawnFrame frame) {
    if (pictures_) MOTE_RETURN_IF_ERROR(pictures_->put({frame.index, frame.key, frame.pixels, {}}));
    if (frame.pixels.format != proto::SRGB8) frame.payload.clear();
    frame.pixels = asBytes(std::move(frame.pixels));
    MOTE_RETURN_IF_ERROR(store_.put(frame.index, frame.key, frame.pixels, std::move(frame.payload)));
    {
        const std::lock_guard lock(mutex_);
        if (outcome_ && !outcome_->ok()) return *outcome_;
        stored_[frame.index] = true;
        if (waiting_.size() < mostWaiting || frame.index == through_)
            waiting_.emplace(frame.index, std::move(frame.pixels));
    }
    changed_.notify_all();
    return success();
}

std::size_t VideoFile::backlog() const {
    const std::lock_guard lock(mutex_);
    return waiting_.size();
}

/// A frame, when it is there. Errors: cancelled (the run ended first), the disk's.
Result<FramePixels> VideoFile::inTurn(std::size_t index) {
    {
        std::unique_lock lock(mutex_);
        through_ = index;
        changed_.wait(lock, [&] { return ending_ || stored_[index]; });
        if (ending_) return Error{ErrorCode::cancelled, "", "interrupted"};
        if (const auto found = waiting_.find(index); found != waiting_.end()) {
            auto pixels = std::move(found->second);
            waiting_.erase(found);
            return pixels;
        }
    }
    return store_.read(index);
}

void VideoFile::encodeAll() {
    giveWayToDrawing();
    Status outcome = success();
    try {
        outcome = videoOfFrames(
            path_, settings_, stored_.size(), [this](std::size_t index) { return inTurn(index); }, key_);
    } catch (const std::exception& failure) {
        outcome = Error{ErrorCode::internal, path_.string(), failure.what()};
    }
    const std::lock_guard lock(mutex_);
    outcome_ = std::move(outcome);
    changed_.notify_all();
}

Status VideoFile::finish(const std::function<bool(std::size_t)>& goOn) {
    {
        std::unique_lock lock(mutex_);
        while (!outcome_) {
            changed_.wait_for(lock, patience, [&] { return outcome_.has_value(); });
            const auto through = through_;
            lock.unlock();
            if (!goOn(through)) return Error{ErrorCode::cancelled, "", "interrupted"};
            lock.lock();
        }
        MOTE_RETURN_IF_ERROR(*outcome_);
    }
    store_.discard();
    return success();
}

std::filesystem::path VideoFile::fileOf(std::size_t) const {
    return path_;
}

std::string VideoFile::kept() const {
    const std::lock_guard lock(mutex_);
    const auto count = std::count(stored_.begin(), stored_.end(), true);
    if (count == 0) return {};
    return fmt::format("{} of {} frames are kept in {}: --resume goes on from there", count, stored_.size(),
                       store_.folder().string());
}

}  // namespace mote::client
