// SPDX-License-Identifier: GPL-3.0-or-later
//
// Encode: a rendered picture becomes the payload of a frame. Pure functions, any thread; the payload's layout
// is in docs/PROTOCOL.md, its decoder in client/shared. FrameEncoder chooses between the encodings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "server/render/plan/picture.h"

struct ZSTD_CCtx_s;

namespace mote::server {

inline constexpr int jpegQuality = 80;

/// What the schema calls a picture's format.
proto::PixelFormat wireFormat(render::PixelFormat format);

/// resourceExhausted: what encoders say if there is no memory for them.
Error outOfMemory();

/// Our own invariant: as many bytes as its size and format say, and at least one pixel.
void checkPicture(const render::Picture& picture);

/// Encodes an srgb8 picture (our own invariant), alpha left out; 4:4:4. Errors: internal, resourceExhausted
/// (memory).
Result<std::vector<std::uint8_t>> encodeJpeg(const render::Picture& picture, int quality = jpegQuality);

/// Pictures of points are noise: higher levels buy a few percent for many milliseconds.
inline constexpr int zstdLevel = 1;

/// Pictures as filtered rows, packed by zstd, with a little memory that is kept from one to the next. One
/// owner, one thread at a time.
class LosslessEncoder {
  public:
    explicit LosslessEncoder(int level = zstdLevel) : level_(level) {}

    /// protocol/wire/row_filter.h, then one zstd frame with its checksum. Every picture bit but alpha comes
    /// back. Errors: internal, resourceExhausted (memory).
    Result<std::vector<std::uint8_t>> encode(const render::Picture& picture);
    /// About how many bytes encode() would make: from a sixteenth of its rows, in a tenth of the time.
    /// Errors: as encode().
    Result<std::size_t> expectedBytes(const render::Picture& picture);

  private:
    struct FreeContext {
        void operator()(ZSTD_CCtx_s* context) const;
    };
    struct Scratch {
        std::unique_ptr<std::uint8_t[]> bytes;
        std::size_t size = 0;
        /// At least so many bytes, not cleared: they are written before they are read. Throws std::bad_alloc.
        std::uint8_t* take(std::size_t wanted);
    };

    Status prepare();
    Result<std::vector<std::uint8_t>> packRows(const render::Picture& picture);
    /// Packs into packed_; returns how many bytes.
    Result<std::size_t> pack(std::size_t filteredSize);

    int level_;
    std::unique_ptr<ZSTD_CCtx_s, FreeContext> context_;
    Scratch filtered_, packed_;
};

}  // namespace mote::server
