// SPDX-License-Identifier: GPL-3.0-or-later
//
// Encode: a rendered picture becomes the payload of a frame. Pure functions, any thread; the payload's layout
// is in docs/PROTOCOL.md, its decoder in client/shared. FrameEncoder chooses between the encodings.
#pragma once

#include <cstdint>
#include <vector>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "server/render/plan/picture.h"

namespace mote::server {

inline constexpr int jpegQuality = 80;

/// What the schema calls a picture's format.
proto::PixelFormat wireFormat(render::PixelFormat format);

/// Our own invariant: as many bytes as its size and format say, and at least one pixel.
void checkPicture(const render::Picture& picture);

/// Encodes an srgb8 picture (our own invariant), alpha left out; 4:4:4. Errors: internal, resourceExhausted
/// (memory).
Result<std::vector<std::uint8_t>> encodeJpeg(const render::Picture& picture, int quality = jpegQuality);

}  // namespace mote::server
