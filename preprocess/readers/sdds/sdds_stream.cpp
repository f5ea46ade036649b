// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/sdds/sdds_stream.h"

#include <algorithm>
#include <cstring>

namespace mote::prep {
namespace {

constexpr std::size_t bufferBytes = 256 * 1024;

}  // namespace

Result<SddsStream> SddsStream::open(const std::filesystem::path& path, Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(auto source, ByteSource::open(path));
    SddsStream stream;
    stream.source_ = std::move(source);
    stream.progress_ = &progress;
    stream.buffer_.resize(bufferBytes);
    return stream;
}

/// The next bytes, where all of the buffer is handed out.
Status SddsStream::fill() {
    bufferOffset_ += end_;
    begin_ = end_ = 0;
    MOTE_ASSIGN_OR_RETURN(const auto got, source_->read(buffer_));
    end_ = got;
    return success();
}

Error SddsStream::cutShort() const {
    return {ErrorCode::corrupt, name(), "is cut short at byte " + std::to_string(offset() + (end_ - begin_))};
}

Result<bool> SddsStream::atEnd() {
    if (begin_ == end_) MOTE_RETURN_IF_ERROR(fill());
    return begin_ == end_;
}

Status SddsStream::read(std::span<char> bytes) {
    for (std::size_t done = 0; done < bytes.size();) {
        MOTE_ASSIGN_OR_RETURN(const auto ended, atEnd());
        if (ended) return cutShort();
        const std::size_t some = std::min(bytes.size() - done, end_ - begin_);
        std::memcpy(bytes.data() + done, buffer_.data() + begin_, some);
        begin_ += some;
        done += some;
    }
    return success();
}

Status SddsStream::skip(std::uint64_t bytes) {
    if (bytes <= end_ - begin_) {
        begin_ += static_cast<std::size_t>(bytes);
        return success();
    }
    if (!source_->compressed()) {
        const std::uint64_t size = source_->fileBytes();
        if (offset() > size || bytes > size - offset()) {
            return corrupt(name(), "is cut short at byte " + std::to_string(size));
        }
        return seek(offset() + bytes);
    }
    while (bytes > 0) {
        if (progress_->cancelled())
            return Error{ErrorCode::cancelled, "", "cancelled while a table was read"};
        MOTE_ASSIGN_OR_RETURN(const auto ended, atEnd());
        if (ended) return cutShort();
        const std::uint64_t some = std::min<std::uint64_t>(bytes, end_ - begin_);
        begin_ += static_cast<std::size_t>(some);
        bytes -= some;
    }
    return success();
}

Status SddsStream::seek(std::uint64_t offset) {
    if (offset >= bufferOffset_ && offset <= bufferOffset_ + end_) {
        begin_ = static_cast<std::size_t>(offset - bufferOffset_);
        return success();
    }
    if (source_->compressed() && offset > this->offset()) return skip(offset - this->offset());
    const std::uint64_t target = source_->compressed() ? 0 : offset;
    MOTE_RETURN_IF_ERROR(source_->seek(target));
    begin_ = end_ = 0;
    bufferOffset_ = target;
    return skip(offset - target);
}

}  // namespace mote::prep
