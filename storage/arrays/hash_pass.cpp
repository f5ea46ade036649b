// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/arrays/hash_pass.h"

#include <oneapi/tbb/parallel_pipeline.h>
#include <oneapi/tbb/task_arena.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <exception>
#include <numeric>
#include <utility>

#include "protocol/base/system_error.h"

namespace mote::storage {

HashPass::HashPass(File file, std::function<bool()> cancelled)
    : file_(std::move(file)), cancelled_(std::move(cancelled)), complete_(file_.places.size(), false) {
    for (const auto& place : file_.places) blocks_.emplace_back((place.bytes + blockBytes - 1) / blockBytes);
}

HashPass::~HashPass() {
    end();
}

void HashPass::begin() {
    status_ = cut();
    if (status_.ok()) thread_ = std::thread([this] { hashAhead(); });
}

void HashPass::complete(std::size_t array) {
    {
        const std::lock_guard lock(mutex_);
        complete_[array] = true;
    }
    changed_.notify_one();
}

Status HashPass::cut() {
    struct stat status {};
    if (::fstat(file_.descriptor, &status) != 0)
        return systemError(errno, file_.path.string(), "cannot be read");
    std::vector<std::size_t> order(blocks_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::sort(order, {}, [&](std::size_t i) { return file_.places[i].offset; });
    std::uint64_t at = 0;
    for (const auto i : order) {
        const auto& place = file_.places[i];
        if (place.bytes == 0) continue;
        cut(at, place.offset, std::nullopt);
        at = place.offset + place.bytes;
        cut(place.offset, at, i);
    }
    cut(at, static_cast<std::uint64_t>(status.st_size), std::nullopt);
    return success();
}

void HashPass::cut(std::uint64_t begin, std::uint64_t end, std::optional<std::size_t> array) {
    constexpr std::uint64_t most = 4 * blockBytes;
    for (std::uint64_t at = begin; at < end; at += most) {
        pieces_.push_back(
            {at, std::min(most, end - at), array, static_cast<std::size_t>((at - begin) / blockBytes)});
    }
}

/// The thread's work: in the order of the file, as far as it is complete.
void HashPass::hashAhead() {
    std::vector<std::byte> bytes;
    try {
        for (; next_ < pieces_.size() && status_.ok(); ++next_) {
            const auto& piece = pieces_[next_];
            {
                std::unique_lock lock(mutex_);
                changed_.wait(lock, [&] { return ending_ || !piece.array || complete_[*piece.array]; });
                if (ending_) return;
            }
            status_ = isCancelled() ? Status(wasCancelled()) : hashBlocks(piece, bytes);
            if (status_.ok()) whole_.add(bytes);
        }
    } catch (const std::exception& failure) {
        status_ = Error{ErrorCode::internal, file_.path.string(), failure.what()};
    }
}

void HashPass::end() {
    if (!thread_.joinable()) return;
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
    }
    changed_.notify_one();
    thread_.join();
}

Error HashPass::wasCancelled() const {
    return {ErrorCode::cancelled, file_.path.string(), "cancelled"};
}

Result<FileHash> HashPass::finish() {
    end();
    if (pieces_.empty() && status_.ok()) status_ = cut();
    MOTE_RETURN_IF_ERROR(status_);
    const auto together = 2 * static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
    // Pieces leave in their order, so that of those under way no two have the same buffer.
    std::vector<std::vector<std::byte>> buffers(together);
    std::vector<Status> read(pieces_.size(), success());
    bool stopped = false;
    const auto take = [&](tbb::flow_control& control) -> std::size_t {
        stopped = stopped || isCancelled();
        if (next_ == pieces_.size() || stopped) control.stop();
        return next_ == pieces_.size() || stopped ? 0 : next_++;
    };
    const auto hash = [&](std::size_t i) {
        read[i] = hashBlocks(pieces_[i], buffers[i % together]);
        return i;
    };
    const auto add = [&](std::size_t i) { whole_.add(buffers[i % together]); };
    tbb::parallel_pipeline(together,
                           tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, take) &
                               tbb::make_filter<std::size_t, std::size_t>(tbb::filter_mode::parallel, hash) &
                               tbb::make_filter<std::size_t, void>(tbb::filter_mode::serial_in_order, add));
    if (stopped) return wasCancelled();
    for (const auto& one : read) MOTE_RETURN_IF_ERROR(one);
    return whole_.hash();
}

Status HashPass::read(const Piece& piece, std::span<std::byte> bytes) const {
    if (piece.array && file_.held &&
        file_.held(*piece.array, piece.offset - file_.places[*piece.array].offset, bytes))
        return success();
    return readAt(file_.descriptor, piece.offset, bytes, file_.path,
                  piece.array ? file_.cache[*piece.array] : PageCache::kept);
}

/// `bytes`: becomes what the piece holds.
Status HashPass::hashBlocks(const Piece& piece, std::vector<std::byte>& bytes) {
    bytes.resize(piece.bytes);
    MOTE_RETURN_IF_ERROR(read(piece, bytes));
    for (std::size_t at = 0, block = piece.firstBlock; piece.array && at < bytes.size();
         at += blockBytes, ++block) {
        blocks_[*piece.array][block] = hashBlock(std::span<const std::byte>(bytes).subspan(
            at, std::min<std::size_t>(blockBytes, bytes.size() - at)));
    }
    return success();
}

}  // namespace mote::storage
