// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/text/row_file.h"

#include <algorithm>
#include <cstring>

namespace mote::prep {
namespace {

constexpr std::size_t bufferBytes = 512 * 1024;
constexpr std::size_t maxLineBytes = 64 * 1024;

constexpr std::uint64_t rowsPerCheckpoint = 1u << 16;
constexpr std::uint64_t rowsPerQuestion = 1u << 16;  // is it cancelled?

}  // namespace

Result<LineReader> LineReader::open(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(auto source, ByteSource::open(path));
    LineReader reader;
    reader.source_ = std::move(source);
    reader.buffer_.resize(bufferBytes);
    return reader;
}

Status LineReader::fill() {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    bufferOffset_ += begin_;
    end_ -= begin_;
    begin_ = 0;
    MOTE_ASSIGN_OR_RETURN(const auto got, source_->read({buffer_.data() + end_, buffer_.size() - end_}));
    atEnd_ = got == 0;
    end_ += got;
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
        return corrupt(name() + ": line " + std::to_string(lineNumber_ + 1),
                       "is longer than 64 KiB; this is no table of particles");
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

Status eachLine(const std::filesystem::path& path, Progress& progress,
                const std::function<Status(std::string_view line, const std::string& where)>& take) {
    MOTE_ASSIGN_OR_RETURN(auto reader, LineReader::open(path));
    for (std::string_view line;;) {
        if (reader.lineNumber() % rowsPerQuestion == 0 && progress.cancelled())
            return wasCancelled("cancelled while a table was read");
        MOTE_ASSIGN_OR_RETURN(const auto more, reader.next(line));
        if (!more) return success();
        MOTE_RETURN_IF_ERROR(take(line, reader.where()));
    }
}

Error noNumber(std::string_view field, const std::string& where, const std::string& column) {
    return corrupt(where + ", column " + column,
                   "'" + std::string(field.substr(0, 40)) + "' is not a number");
}

bool isRow(std::string_view line) {
    const std::size_t first = line.find_first_not_of(" \t\r");
    return first != std::string_view::npos && line[first] != '#' && line[first] != '!' && line[first] != '%';
}

Result<RowFile> RowFile::open(const std::filesystem::path& path, std::uint64_t skipped, Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(auto reader, LineReader::open(path));
    RowFile file;
    file.path_ = path;
    file.skipped_ = skipped;
    file.checkpoints_.push_back({});
    std::uint64_t row = 0;
    for (std::string_view line;;) {
        if (row % rowsPerCheckpoint == 0 && row > file.checkpoints_.back().row && !reader.compressed()) {
            file.checkpoints_.push_back({row, reader.offset(), reader.lineNumber()});
        }
        // Asked by lines, so that a file of nothing but comments can be left too.
        if (reader.lineNumber() % rowsPerQuestion == 0 && progress.cancelled())
            return wasCancelled("cancelled while a table was read");
        MOTE_ASSIGN_OR_RETURN(const auto more, reader.next(line));
        if (!more) break;
        if (isRow(line)) ++row;
    }
    file.rows_ = row - std::min(row, skipped);
    return file;
}

Result<bool> RowFile::nextRow(std::string_view& row) {
    do {
        auto more = reader_->next(row);
        if (!more || !*more) return more;
    } while (!isRow(row));
    ++position_;
    return true;
}

Status RowFile::seek(std::uint64_t row, Progress& progress) {
    row += skipped_;
    if (!reader_) {
        MOTE_ASSIGN_OR_RETURN(auto reader, LineReader::open(path_));
        reader_ = std::move(reader);
        position_ = 0;
    }
    const auto after =
        std::upper_bound(checkpoints_.begin(), checkpoints_.end(), row,
                         [](std::uint64_t wanted, const Checkpoint& c) { return wanted < c.row; });
    const Checkpoint& checkpoint = *std::prev(after);
    if (row < position_ || checkpoint.row > position_) {
        MOTE_RETURN_IF_ERROR(reader_->seek(checkpoint.offset, checkpoint.lines));
        position_ = checkpoint.row;
    }
    for (std::string_view line; position_ < row;) {
        if (position_ % rowsPerQuestion == 0 && progress.cancelled())
            return wasCancelled("cancelled while a table was read");
        MOTE_ASSIGN_OR_RETURN(const auto more, nextRow(line));
        if (!more) return corrupt(reader_->name(), "has changed since it was opened");
    }
    return success();
}

Result<std::string_view> RowFile::next() {
    std::string_view row;
    MOTE_ASSIGN_OR_RETURN(const auto more, nextRow(row));
    if (!more) return corrupt(reader_->name(), "has changed since it was opened");
    return row;
}

std::string RowFile::where() const {
    return path_.filename().string() + (reader_ ? ": line " + std::to_string(reader_->lineNumber()) : "");
}

}  // namespace mote::prep
