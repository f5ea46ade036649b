// SPDX-License-Identifier: GPL-3.0-or-later
//
// LineReader: a text file line by line, through one buffer whatever the file's size. One owner, one thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string_view>
#include <vector>

#include "preprocess/readers/text/byte_source.h"
#include "protocol/scene/error.h"

namespace mote::prep {

class LineReader {
  public:
    /// Errors as of ByteSource::open.
    static Result<LineReader> open(const std::filesystem::path& path);

    /// The next line without its end, valid until the next call. False at the end of the file. Errors:
    /// corrupt (a line of more than 64 KiB, damaged gzip data), those of ByteSource::read.
    Result<bool> next(std::string_view& line);

    /// The number of the line that next() returned last, from 1.
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

}  // namespace mote::prep
