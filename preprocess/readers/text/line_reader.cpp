// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/text/line_reader.h"

#include <cstring>

namespace mote::prep {
namespace {

constexpr std::size_t bufferBytes = 512 * 1024;
constexpr std::size_t maxLineBytes = 64 * 1024;

}  // namespace

Result<LineReader> LineReader::open(const std::filesystem::path& path) {
    auto source = ByteSource::open(path);
    if (!source) return source.error();
    LineReader reader;
    reader.source_ = std::move(*source);
    reader.buffer_.resize(bufferBytes);
    return reader;
}

Status LineReader::fill() {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    bufferOffset_ += begin_;
    end_ -= begin_;
    begin_ = 0;
    const auto got = source_->read({buffer_.data() + end_, buffer_.size() - end_});
    if (!got) return got.error();
    atEnd_ = *got == 0;
    end_ += *got;
    return success();
}

Result<bool> LineReader::next(std::string_view& line) {
    const char* found = nullptr;
    for (std::size_t searched = 0;;) {
        const char* from = buffer_.data() + begin_ + searched;
        found = static_cast<const char*>(std::memchr(from, '\n', end_ - begin_ - searched));
        searched = end_ - begin_;
        if (found != nullptr || atEnd_) break;
        if (searched > maxLineBytes) break;
        MOTE_RETURN_IF_ERROR(fill());
    }
    const std::size_t length =
        found != nullptr ? static_cast<std::size_t>(found - buffer_.data()) - begin_ : end_ - begin_;
    if (length > maxLineBytes) {
        return Error{ErrorCode::corrupt, name() + ": line " + std::to_string(lineNumber_ + 1),
                     "is longer than 64 KiB; this is no table of particles"};
    }
    if (found == nullptr && length == 0) return false;
    line = {buffer_.data() + begin_, length};
    begin_ += length + (found != nullptr ? 1 : 0);
    ++lineNumber_;
    if (line.ends_with('\r')) line.remove_suffix(1);
    return true;
}

Status LineReader::seek(std::uint64_t offset, std::uint64_t lines) {
    MOTE_RETURN_IF_ERROR(source_->seek(offset));
    begin_ = end_ = 0;
    bufferOffset_ = offset;
    lineNumber_ = lines;
    atEnd_ = false;
    return success();
}

}  // namespace mote::prep
