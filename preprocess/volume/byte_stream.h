// SPDX-License-Identifier: GPL-3.0-or-later
//
// ByteStream: the bytes of a volume, whatever they are wrapped in: files, parts of files, compressed data,
// base64 (RFC 4648), VTK's blocks, each compressed for itself. Streams are put into one another; each owns
// the one it reads. One owner, one thread at a time.
#pragma once

#include <cstddef>
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

class ByteStream {
  public:
    virtual ~ByteStream() = default;
    virtual std::string name() const = 0;  ///< of the file, for errors
    /// Whether going back means to read again from the beginning.
    virtual bool sequential() const = 0;
    /// How many bytes there are, if that is known without reading them.
    virtual std::optional<std::uint64_t> size() const = 0;
    /// No more bytes than this can come out; size() if that is known.
    virtual std::uint64_t mostBytes() const = 0;
    /// Fills as much of `bytes` as there is; less only at the end. Errors: corrupt (damaged or cut data),
    /// resourceExhausted, internal.
    virtual Result<std::size_t> read(std::span<char> bytes) = 0;
    /// What is read next; the end if `offset` lies behind it. Errors as of read.
    virtual Status seek(std::uint64_t offset) = 0;
};

using ByteStreamPtr = std::unique_ptr<ByteStream>;

/// A stream that only goes forward, and begins anew if earlier bytes are wanted.
class ForwardStream : public ByteStream {
  public:
    bool sequential() const final { return true; }
    std::optional<std::uint64_t> size() const final { return std::nullopt; }
    Result<std::size_t> read(std::span<char> bytes) final;
    Status seek(std::uint64_t offset) final;

  protected:
    virtual Result<std::size_t> next(std::span<char> bytes) = 0;  ///< as read()
    virtual Status restart() = 0;

  private:
    std::uint64_t position_ = 0;
};

/// A regular file, decompressed if it is gzipped. Errors: notFound, permissionDenied, unsupported (not a
/// regular file), internal.
Result<ByteStreamPtr> fileStream(const std::filesystem::path& path);

/// What follows the first `begin` bytes, `length` of them or all. Errors as of read.
Result<ByteStreamPtr> partStream(ByteStreamPtr whole, std::uint64_t begin,
                                 std::optional<std::uint64_t> length = std::nullopt);

/// What comes out of compressed data. Errors: internal.
Result<ByteStreamPtr> inflatedStream(ByteStreamPtr compressed, Inflater::Form form);

/// The most bytes that `bytes` of deflate data can become.
std::uint64_t mostInflated(std::uint64_t bytes);

/// Reads its first bytes, at most `limit` of them; the stream stands behind them. Errors as of read.
Result<std::string> readHead(ByteStream& stream, std::size_t limit);

/// The bytes that `text` stands for, to its end or to a '<'; blanks and line ends are stepped over. Groups
/// that end with '=' may stand anywhere: VTK writes several texts one after the other. Reading: corrupt where
/// a character means nothing.
ByteStreamPtr base64Stream(ByteStreamPtr text);

struct ZlibBlocks {
    std::uint64_t blockBytes = 0;           ///< of each block, decompressed, but for the last one
    std::uint64_t bytes = 0;                ///< decompressed, in all
    std::vector<std::uint64_t> compressed;  ///< bytes of each block, one after the other
};

/// What comes out of the blocks in `data`, which begins with the first one. Errors: corrupt (more than the
/// data can hold), internal.
Result<ByteStreamPtr> zlibBlockStream(ByteStreamPtr data, ZlibBlocks blocks);

}  // namespace mote::prep
