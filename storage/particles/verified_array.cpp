// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/particles/verified_array.h"

#include <fmt/format.h>

#include <algorithm>

#include "storage/hash.h"
#include "storage/storage_error.h"

namespace mote::storage {
namespace {

/// 0 for a type that there is not.
std::uint64_t elementBytes(const std::string& type) {
    if (type == "u8") return 1;
    if (type == "u16") return 2;
    if (type == "u32" || type == "f32") return 4;
    return type == "u64" ? 8 : 0;
}

/// Bytes of the array, or nothing where they are more than `limit`.
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

Result<VerifiedArray> VerifiedArray::make(std::string file, std::span<const std::byte> bytes,
                                          const proto::DigestArray& digest) {
    VerifiedArray array;
    array.where_ = std::move(file) + ":" + digest.name();
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
    array.verified_ = std::make_unique<std::atomic<std::uint64_t>[]>((array.blocks_.size() + 63) / 64);
    return array;
}

std::uint64_t VerifiedArray::size() const {
    return bytes_.size() / elementBytes(type_);
}

std::optional<Error> VerifiedArray::checkBlock(std::size_t block) const {
    const std::uint64_t begin = block * blockBytes;
    const auto bytes = bytes_.subspan(begin, std::min<std::uint64_t>(blockBytes, bytes_.size() - begin));
    if (hashBlock(bytes) == blocks_[block]) return std::nullopt;
    return Error{
        ErrorCode::corrupt, where_,
        fmt::format("the block at byte {} of the array (byte {} of the file) differs from its digest; the "
                    "file is damaged: copy or make it again",
                    begin, offset_ + begin)};
}

void VerifiedArray::verify(std::uint64_t offset, std::uint64_t length) const {
    MOTE_CHECK(offset <= bytes_.size() && length <= bytes_.size() - offset);
    if (length == 0) return;
    const std::size_t last = (offset + length - 1) / blockBytes;
    for (std::size_t block = offset / blockBytes; block <= last; ++block) {
        auto& word = verified_[block / 64];
        const std::uint64_t bit = 1ULL << (block % 64);
        // The bytes never change, so the bits order nothing else.
        if (word.load(std::memory_order_relaxed) & bit) continue;
        if (auto error = checkBlock(block)) throw StorageError(*std::move(error));
        word.fetch_or(bit, std::memory_order_relaxed);
    }
}

}  // namespace mote::storage
