// SPDX-License-Identifier: GPL-3.0-or-later
//
// ArrayBytes: part of a file as bytes that can be read from anywhere, unpacked where it is deflated. Going
// back in a deflated part begins anew, so read it in order. What is read from end to end is held against the
// part's checksum. Owned by a reader; one thread at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "preprocess/readers/text/byte_source.h"
#include "protocol/base/error.h"

namespace mote::prep {

class ArrayBytes {
  public:
    /// Which part of which file.
    struct Part {
        std::filesystem::path file;
        std::string where;              ///< for messages: "beam.npz: x"
        std::uint64_t offset = 0;       ///< of its first byte in the file
        std::uint64_t storedBytes = 0;  ///< in the file
        std::uint64_t bytes = 0;        ///< unpacked
        bool deflated = false;
        std::optional<std::uint32_t> checksum;  ///< CRC-32 of the unpacked bytes
    };

    /// Errors: those of ByteSource::open and Inflater::make.
    static Result<ArrayBytes> open(Part part);

    /// Bytes [offset, offset + bytes.size()), which must lie within the part. Errors: corrupt (damaged or cut
    /// data, another checksum once the last byte is read), internal.
    Status read(std::uint64_t offset, std::span<char> bytes);
    /// Reads on to the part's end, for its checksum, where at most `most` bytes are left.
    Status finish(std::uint64_t most);

  private:
    ArrayBytes() = default;
    Status goTo(std::uint64_t offset);
    Status next(std::span<char> bytes);
    Status begin();

    Part part_;
    std::unique_ptr<ByteSource> source_;
    std::unique_ptr<Inflater> inflater_;
    std::uint64_t fileOffset_ = 0;  // of the bytes that go next into the inflater
    std::uint64_t position_ = 0;    // of the byte that next() returns
    std::uint32_t checksum_ = 0;    // of all before it
    bool checking_ = false;         // nothing before it was stepped over
    std::vector<char> skipped_;
};

}  // namespace mote::prep
