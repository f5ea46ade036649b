// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/npy/array_bytes.h"

#include <zlib.h>

#include <algorithm>

namespace mote::prep {
namespace {

/// What is read where bytes are stepped over, at once; a greater gap in a file is jumped.
constexpr std::size_t skipBytes = 64 * 1024;
/// zlib counts in 32 bits.
constexpr std::size_t maxAtOnce = 1u << 30;

}  // namespace

Result<ArrayBytes> ArrayBytes::open(Part part) {
    ArrayBytes bytes;
    bytes.part_ = std::move(part);
    MOTE_ASSIGN_OR_RETURN(bytes.source_, ByteSource::open(bytes.part_.file));
    if (bytes.part_.deflated) {
        MOTE_ASSIGN_OR_RETURN(bytes.inflater_, Inflater::make(Inflater::Form::raw, bytes.part_.where));
    }
    MOTE_RETURN_IF_ERROR(bytes.begin());
    return bytes;
}

Status ArrayBytes::begin() {
    position_ = 0;
    fileOffset_ = 0;
    checksum_ = static_cast<std::uint32_t>(crc32(0, nullptr, 0));
    checking_ = part_.checksum.has_value();
    if (inflater_) MOTE_RETURN_IF_ERROR(inflater_->reset());
    return source_->seek(part_.offset);
}

/// The bytes that follow the ones before.
Status ArrayBytes::next(std::span<char> bytes) {
    const auto fromFile = [this](std::span<char> some) -> Result<std::size_t> {
        const std::uint64_t left = part_.storedBytes - fileOffset_;
        const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(left, some.size()));
        MOTE_ASSIGN_OR_RETURN(const auto got, source_->read(some.first(count)));
        fileOffset_ += got;
        return got;
    };
    while (!bytes.empty()) {
        const auto some = bytes.first(std::min(bytes.size(), maxAtOnce));
        MOTE_ASSIGN_OR_RETURN(const auto got, inflater_ ? inflater_->read(some, fromFile) : fromFile(some));
        if (got == 0) return corrupt(part_.where, "is shorter than its file says");
        if (checking_) {
            checksum_ = static_cast<std::uint32_t>(
                crc32(checksum_, reinterpret_cast<const Bytef*>(some.data()), static_cast<uInt>(got)));
        }
        position_ += got;
        bytes = bytes.subspan(got);
    }
    if (checking_ && position_ == part_.bytes && checksum_ != *part_.checksum) {
        return corrupt(part_.where, "is damaged: its checksum is not the one it should have");
    }
    return success();
}

Status ArrayBytes::goTo(std::uint64_t offset) {
    if (offset < position_) MOTE_RETURN_IF_ERROR(begin());
    if (!inflater_ && offset - position_ > skipBytes) {
        checking_ = false;
        position_ = fileOffset_ = offset;
        return source_->seek(part_.offset + offset);
    }
    skipped_.resize(skipBytes);
    while (position_ < offset) {
        const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(skipBytes, offset - position_));
        MOTE_RETURN_IF_ERROR(next({skipped_.data(), count}));
    }
    return success();
}

Status ArrayBytes::read(std::uint64_t offset, std::span<char> bytes) {
    MOTE_CHECK(offset <= part_.bytes && bytes.size() <= part_.bytes - offset);
    MOTE_RETURN_IF_ERROR(goTo(offset));
    return next(bytes);
}

Status ArrayBytes::finish(std::uint64_t most) {
    return part_.bytes - position_ > most ? success() : goTo(part_.bytes);
}

}  // namespace mote::prep
