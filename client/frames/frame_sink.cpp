// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/frame_sink.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <xxhash.h>
#include <algorithm>
#include <exception>
#include <utility>

#include "protocol/scene/film/film_job.h"

namespace mote::client {

std::string keyOf(std::string_view text) {
    const XXH128_hash_t hash = XXH3_128bits(text.data(), text.size());
    return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

PictureFiles::~PictureFiles() {
    std::error_code ignored;
    if (made_) std::filesystem::remove(folder_, ignored);  // fails where there is a picture: as it should
}

Status PictureFiles::open(bool) {
    std::error_code code;
    made_ = std::filesystem::create_directories(folder_, code);
    if (!code && std::filesystem::is_directory(folder_)) return success();
    if (!code) return Error{ErrorCode::alreadyExists, folder_.string(), "is no folder"};
    const bool denied = code == std::errc::permission_denied;
    return Error{denied ? ErrorCode::permissionDenied : ErrorCode::internal, folder_.string(),
                 "the folder cannot be made: " + code.message()};
}

bool PictureFiles::has(std::size_t index, std::string_view key, std::uint32_t width,
                       std::uint32_t height) const {
    return readPictureKey(fileOf(index), format_, width, height) == key;
}

Status PictureFiles::put(DrawnFrame frame) {
    MOTE_ASSIGN_OR_RETURN(const auto bytes, encodePicture(frame.pixels, format_, frame.key));
    return writeFile(fileOf(frame.index), bytes);
}

std::filesystem::path PictureFiles::fileOf(std::size_t index) const {
    return folder_ / pictureName(index, extension(format_));
}

void giveWayToDrawing() {
    constexpr int niceness = 10;
    // On Linux a priority is a thread's own.
    ::setpriority(PRIO_PROCESS, 0, ::getpriority(PRIO_PROCESS, 0) + niceness);
}

FinishingThreads::FinishingThreads(FrameSink& sink, unsigned threads, std::function<void()> wake)
    : sink_(sink), wake_(std::move(wake)) {
    for (unsigned i = 0; i < threads; ++i) threads_.emplace_back([this] { work(); });
}

FinishingThreads::~FinishingThreads() {
    end();
}

/// Waits for what is under way and drops the rest.
void FinishingThreads::end() {
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
        waiting_.clear();
    }
    changed_.notify_all();
    for (auto& thread : threads_) thread.join();
    threads_.clear();
}

void FinishingThreads::post(DrawnFrame frame) {
    ++open_;
    {
        const std::lock_guard lock(mutex_);
        waiting_.push_back(std::move(frame));
    }
    changed_.notify_one();
}

Result<std::vector<std::size_t>> FinishingThreads::take() {
    std::unique_lock lock(mutex_);
    const auto failed = [](const Finished& finished) { return !finished.status.ok(); };
    if (std::ranges::any_of(finished_, failed)) {
        // Threads fail in any order; who runs a script again hears the same.
        lock.unlock();
        end();
        std::erase_if(finished_, [&](const Finished& finished) { return !failed(finished); });
        return std::ranges::min_element(finished_, {}, &Finished::index)->status.error();
    }
    std::vector<std::size_t> frames;
    for (const auto& finished : finished_) frames.push_back(finished.index);
    finished_.clear();
    open_ -= frames.size();
    return frames;
}

void FinishingThreads::work() {
    giveWayToDrawing();
    std::unique_lock lock(mutex_);
    while (true) {
        changed_.wait(lock, [&] { return ending_ || !waiting_.empty(); });
        if (ending_) return;
        DrawnFrame frame = std::move(waiting_.front());
        waiting_.pop_front();
        lock.unlock();
        Finished finished{frame.index};
        try {
            finished.status = sink_.put(std::move(frame));
        } catch (const std::exception& failure) {
            finished.status = Error{ErrorCode::internal, "", failure.what()};
        }
        lock.lock();
        finished_.push_back(std::move(finished));
        wake_();
    }
}

}  // namespace mote::client
