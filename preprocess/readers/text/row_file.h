// SPDX-License-Identifier: GPL-3.0-or-later
//
// RowFile: the rows of a text table, counted once and then read from any row on. Nothing of the table is kept
// but the places of some rows (24 bytes for each 65536); a compressed file is read again from its beginning
// where an earlier row is asked for. Owned by a reader; one thread at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/readers/text/byte_source.h"
#include "protocol/base/error.h"

namespace mote::prep {

/// A text file line by line, through one buffer whatever the file's size. One owner, one thread.
class LineReader {
  public:
    /// Errors as of ByteSource::open.
    static Result<LineReader> open(const std::filesystem::path& path);

    /// The next line without its end, valid until the next call. False at the end of the file. Errors:
    /// corrupt (a line of more than 64 KiB, damaged gzip data), those of ByteSource::read.
    Result<bool> next(std::string_view& line);

    /// "beam.dat: line 12", of the line that next() returned last.
    std::string where() const { return name() + ": line " + std::to_string(lineNumber_); }
    /// The number of that line, from 1.
    std::uint64_t lineNumber() const { return lineNumber_; }
    /// Where the line that next() will return begins, bytes of the text.
    std::uint64_t offset() const { return bufferOffset_ + begin_; }
    bool compressed() const { return source_->compressed(); }
    const std::string& name() const { return source_->name(); }

    /// Goes to the line at `offset`, before which stand `lines` lines; only 0, 0 in a compressed file.
    Status seek(std::uint64_t offset, std::uint64_t lines);

  private:
    Status fill();

    std::unique_ptr<ByteSource> source_;
    std::vector<char> buffer_;
    std::size_t begin_ = 0, end_ = 0;  // what is not yet handed out
    std::uint64_t bufferOffset_ = 0;   // of the buffer's first byte
    std::uint64_t lineNumber_ = 0;
    bool atEnd_ = false;
};

/// Calls `take` with each line of a file, and with where that is: "beam.dat: line 12". Errors: those of
/// LineReader and of `take`; cancelled.
Status eachLine(const std::filesystem::path& path, Progress& progress,
                const std::function<Status(std::string_view line, const std::string& where)>& take);

/// "'x' is not a number", of a field of a row.
Error noNumber(std::string_view field, const std::string& where, const std::string& column);

class RowFile {
  public:
    /// Counts the rows: lines that are neither blank nor a comment ('#', '!' or '%'), the first `skipped` of
    /// them left out. Errors: those of LineReader, cancelled.
    static Result<RowFile> open(const std::filesystem::path& path, std::uint64_t skipped, Progress& progress);

    std::uint64_t rows() const { return rows_; }
    const std::filesystem::path& path() const { return path_; }

    /// Makes `row` the one that next() returns. Errors as of LineReader, corrupt (the file has shrunk).
    Status seek(std::uint64_t row, Progress& progress);
    /// The row, valid until the next call. Errors as of seek.
    Result<std::string_view> next();
    /// "beam.csv: line 12", of the last row, for messages.
    std::string where() const;
    /// Gives back buffer and descriptor; the next seek takes them again.
    void close() { reader_.reset(); }

  private:
    struct Checkpoint {
        std::uint64_t row = 0, offset = 0, lines = 0;
    };

    Result<bool> nextRow(std::string_view& row);

    std::filesystem::path path_;
    std::uint64_t skipped_ = 0, rows_ = 0;
    std::vector<Checkpoint> checkpoints_;
    std::optional<LineReader> reader_;
    std::uint64_t position_ = 0;  // the row that next() returns, skipped ones included
};

/// True for a line that is neither blank nor a comment.
bool isRow(std::string_view line);

}  // namespace mote::prep
