// SPDX-License-Identifier: GPL-3.0-or-later
//
// Encode: a rendered picture becomes the payload of a frame. JPEG while the view moves, lossless at rest.
// Pure functions, any thread; the payload's layout is in docs/PROTOCOL.md, its decoder in client/shared.
//
// 4:4:4, as pictures of points are single coloured pixels that subsampled chroma ruins; zstd's level 1, as
// such pictures are noise and higher levels buy a few percent for many milliseconds.
#pragma once

#include <cstdint>
#include <vector>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "server/render/picture.h"

namespace mote::server {

inline constexpr int jpegQuality = 80;
inline constexpr int zstdLevel = 1;

/// What the schema calls a picture's format.
proto::PixelFormat wireFormat(render::PixelFormat format);

/// Of an srgb8 picture (our own invariant), alpha left out. Errors: internal, resourceExhausted (memory).
Result<std::vector<std::uint8_t>> encodeJpeg(const render::Picture& picture, int quality = jpegQuality);

/// Of any picture: protocol/wire/row_filter.h, then one zstd frame with its checksum. Every picture bit but
/// alpha comes back. Errors: internal, resourceExhausted (memory).
Result<std::vector<std::uint8_t>> encodeLossless(const render::Picture& picture, int level = zstdLevel);

}  // namespace mote::server
