// SPDX-License-Identifier: GPL-3.0-or-later
//
// SddsStream: the bytes of binary SDDS pages, through one buffer, with their place. A compressed file is read
// again from its beginning where an earlier place is asked for. One owner, one thread; `progress` must
// outlive it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/readers/text/byte_source.h"
#include "protocol/scene/error.h"

namespace mote::prep {

class SddsStream {
  public:
    /// Errors as of ByteSource::open.
    static Result<SddsStream> open(const std::filesystem::path& path, Progress& progress);

    const std::string& name() const { return source_->name(); }
    std::uint64_t offset() const { return bufferOffset_ + begin_; }

    /// Whether no byte is left.
    Result<bool> atEnd();
    /// Fills `bytes`. Errors: corrupt (cut short, with the byte), those of ByteSource::read.
    Status read(std::span<char> bytes);
    /// Steps over bytes that must be there. Errors: as of read, cancelled.
    Status skip(std::uint64_t bytes);
    /// Goes to a place. Errors: as of skip.
    Status seek(std::uint64_t offset);

  private:
    Status fill();
    Error cutShort() const;

    std::unique_ptr<ByteSource> source_;
    Progress* progress_ = nullptr;
    std::vector<char> buffer_;
    std::size_t begin_ = 0, end_ = 0;  // what is not yet handed out
    std::uint64_t bufferOffset_ = 0;   // of the buffer's first byte
};

}  // namespace mote::prep
