// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/text/row_file.h"

#include <algorithm>

namespace mote::prep {
namespace {

constexpr std::uint64_t rowsPerCheckpoint = 1u << 16;
constexpr std::uint64_t rowsPerQuestion = 1u << 16;  // is it cancelled?

Error cancelled() {
    return {ErrorCode::cancelled, "", "cancelled while a table was read"};
}

}  // namespace

bool isRow(std::string_view line) {
    const std::size_t first = line.find_first_not_of(" \t\r");
    return first != std::string_view::npos && line[first] != '#' && line[first] != '!' && line[first] != '%';
}

Result<RowFile> RowFile::open(const std::filesystem::path& path, std::uint64_t skipped, Progress& progress) {
    auto reader = LineReader::open(path);
    if (!reader) return reader.error();
    RowFile file;
    file.path_ = path;
    file.skipped_ = skipped;
    file.checkpoints_.push_back({});
    std::uint64_t row = 0;
    for (std::string_view line;;) {
        if (row % rowsPerCheckpoint == 0 && row > file.checkpoints_.back().row && !reader->compressed()) {
            file.checkpoints_.push_back({row, reader->offset(), reader->lineNumber()});
        }
        // Asked by lines, so that a file of nothing but comments can be left too.
        if (reader->lineNumber() % rowsPerQuestion == 0 && progress.cancelled()) return cancelled();
        const auto more = reader->next(line);
        if (!more) return more.error();
        if (!*more) break;
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
        auto reader = LineReader::open(path_);
        if (!reader) return reader.error();
        reader_ = std::move(*reader);
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
        if (position_ % rowsPerQuestion == 0 && progress.cancelled()) return cancelled();
        const auto more = nextRow(line);
        if (!more) return more.error();
        if (!*more) return Error{ErrorCode::corrupt, reader_->name(), "has changed since it was opened"};
    }
    return success();
}

Result<std::string_view> RowFile::next() {
    std::string_view row;
    const auto more = nextRow(row);
    if (!more) return more.error();
    if (!*more) return Error{ErrorCode::corrupt, reader_->name(), "has changed since it was opened"};
    return row;
}

std::string RowFile::where() const {
    return path_.filename().string() + (reader_ ? ": line " + std::to_string(reader_->lineNumber()) : "");
}

}  // namespace mote::prep
