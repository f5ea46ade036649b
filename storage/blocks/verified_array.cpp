// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/blocks/verified_array.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "protocol/base/mote_check.h"
#include "storage/arrays/hdf5_layout.h"
#include "storage/hash.h"
#include "storage/storage_error.h"

namespace mote::storage {
namespace {

/// Bytes of the array, or nothing if they are more than `limit`.
std::optional<std::uint64_t> arrayBytes(const proto::DigestArray& digest, std::uint64_t limit) {
    std::uint64_t bytes = elementBytes(digest.type());
    for (const auto extent : digest.shape()) {
        if (extent == 0) return 0;
    }
    for (const auto extent : digest.shape()) {
        if (extent > limit / bytes) return std::nullopt;
        bytes *= extent;
    }
    return bytes;
}

}  // namespace

Result<VerifiedArray> VerifiedArray::make(const MappedFile& file, const proto::DigestArray& digest,
                                          BlockBudget* budget) {
    VerifiedArray array;
    const auto bytes = file.bytes();
    array.file_ = &file;
    array.budget_ = budget;
    array.where_ = file.path() + ":" + digest.name();
    const auto corrupt = [&](std::string message) {
        return Error{ErrorCode::corrupt, array.where_, std::move(message)};
    };
    const auto element = elementBytes(digest.type());
    if (element == 0) return corrupt(fmt::format("the digest knows no type \"{}\"", digest.type()));
    if (digest.shape_size() < 1 || digest.shape_size() > 3)
        return corrupt("the digest gives no sensible shape");
    const auto size = arrayBytes(digest, bytes.size());
    if (!size || digest.offset() > bytes.size() - *size) {
        return corrupt(fmt::format("lies beyond the end of the file, which has {} bytes", bytes.size()));
    }
    if (digest.offset() % element != 0) return corrupt("lies at an odd offset");
    if (static_cast<std::uint64_t>(digest.blocks_size()) != (*size + blockBytes - 1) / blockBytes) {
        return corrupt("the digest has not one hash for each MiB");
    }
    array.type_ = digest.type();
    array.shape_.assign(digest.shape().begin(), digest.shape().end());
    array.offset_ = digest.offset();
    array.bytes_ = bytes.subspan(digest.offset(), *size);
    array.blocks_.assign(digest.blocks().begin(), digest.blocks().end());
    array.used_ = std::make_unique<std::atomic<BlockBudget::Generation>[]>(array.blocks_.size());
    return array;
}

std::uint64_t VerifiedArray::size() const {
    return bytes_.size() / elementBytes(type_);
}

std::uint64_t VerifiedArray::blockSize(std::size_t block) const {
    return std::min<std::uint64_t>(blockBytes, bytes_.size() - block * blockBytes);
}

/// What is read of a block, where it lies or in a copy.
std::optional<Error> VerifiedArray::holdToDigest(std::size_t block, std::span<const std::byte> bytes) const {
    const bool matches = hashBlock(bytes) == blocks_[block];
    if (file_->faulted()) return file_->damage();
    if (matches) return std::nullopt;
    const std::uint64_t begin = block * blockBytes;
    return Error{
        ErrorCode::corrupt, where_,
        fmt::format("the block at byte {} of the array (byte {} of the file) differs from its digest; the "
                    "file is damaged: copy or make it again",
                    begin, offset_ + begin)};
}

std::optional<Error> VerifiedArray::checkBlock(std::size_t block) const {
    const std::uint64_t begin = block * blockBytes;
    file_->populate(offset_ + begin, blockSize(block));
    return holdToDigest(block, bytes_.subspan(begin, blockSize(block)));
}

void VerifiedArray::copyBlock(std::size_t block, std::span<std::byte> to) const {
    MOTE_CHECK(to.size() == blockSize(block));
    const std::uint64_t begin = block * blockBytes;
    file_->populate(offset_ + begin, to.size());
    std::memcpy(to.data(), bytes_.data() + begin, to.size());
    if (auto error = holdToDigest(block, to)) throw StorageError(*std::move(error));
    if (usedIn(block) == 0) file_->giveUp(offset_ + begin, to.size());
}

/// Marks a block used if it is in memory.
bool VerifiedArray::touch(std::size_t block, BlockBudget::Generation generation) const {
    auto used = used_[block].load(std::memory_order_relaxed);
    while (used != 0) {
        if (used >= generation) return true;
        if (used_[block].compare_exchange_weak(used, generation, std::memory_order_relaxed)) return true;
    }
    return false;
}

/// A block for which the budget has taken its bytes.
void VerifiedArray::load(std::size_t block, BlockBudget::Generation generation) const {
    auto error = checkBlock(block);
    BlockBudget::Generation absent = 0;
    // The bytes never change, so the mark orders nothing else.
    const bool first =
        !error && used_[block].compare_exchange_strong(absent, generation, std::memory_order_relaxed);
    if (!first && budget_) budget_->giveBack(blockSize(block));
    if (error) throw StorageError(*std::move(error));
}

bool VerifiedArray::bring(std::size_t block, BlockBudget::Generation generation) const {
    if (touch(block, generation)) return true;
    if (budget_ && !budget_->take(blockSize(block), generation)) return false;
    load(block, generation);
    return true;
}

/// What is asked for comes in, if need be in the place of something of the same generation, which whoever
/// reads on through more than there is room for has left behind.
void VerifiedArray::bringForUse(std::size_t block) const {
    const auto generation = budget_ ? budget_->generation() : 1;
    if (touch(block, generation)) return;
    const auto size = blockSize(block);
    if (budget_ && !budget_->take(size, generation) && !budget_->take(size, generation + 1))
        budget_->takeAnyway(size);
    load(block, generation);
}

void VerifiedArray::expect(std::size_t block) const {
    file_->expect(offset_ + block * blockBytes, blockSize(block));
}

std::uint64_t VerifiedArray::giveUp(std::size_t block, Generation used) const {
    if (!used_[block].compare_exchange_strong(used, 0, std::memory_order_relaxed)) return 0;
    file_->giveUp(offset_ + block * blockBytes, blockSize(block));
    return blockSize(block);
}

std::uint64_t VerifiedArray::ready(std::uint64_t offset, std::uint64_t length) const {
    MOTE_CHECK(offset <= bytes_.size() && length <= bytes_.size() - offset);
    const std::uint64_t end = offset + length;
    if (!budget_) return length;
    std::uint64_t at = offset;
    while (at < end && usedIn(at / blockBytes) != 0) at = (at / blockBytes + 1) * blockBytes;
    return std::min(at, end) - offset;
}

void VerifiedArray::use(std::uint64_t offset, std::uint64_t length) const {
    MOTE_CHECK(offset <= bytes_.size() && length <= bytes_.size() - offset);
    if (length == 0) return;
    if (budget_ && length > budget_->limit()) {
        throw StorageError(
            Error{ErrorCode::resourceExhausted, where_,
                  fmt::format("{} MiB are needed at once, and {} MiB may be used; raise --memory",
                              length >> 20, budget_->limit() >> 20)});
    }
    const std::size_t last = (offset + length - 1) / blockBytes;
    for (std::size_t block = offset / blockBytes; block <= last; ++block) bringForUse(block);
    // Also of what was brought in before: the file may have lost it since.
    if (!file_->faulted()) return;
    if (auto damage = file_->damage()) throw StorageError(*std::move(damage));
}

}  // namespace mote::storage
