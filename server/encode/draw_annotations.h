// SPDX-License-Identifier: GPL-3.0-or-later
//
// Draws a frame's annotations onto its finished pixels, for every device and quality in this one place. A
// function, any thread.
#pragma once

#include <cstdint>

#include "protocol/base/error.h"
#include "server/figures/marks.h"
#include "server/render/plan/picture.h"

namespace mote::server {

/// `marks` in pixels of a view of `width` x `height`, of which the picture may have fewer. The edges of lines
/// and letters are mixed with what is beneath them as it is encoded, as drawing programs do and as letters
/// are made for; of a linear picture in linear light. Errors: resourceExhausted (memory), internal.
Status drawAnnotations(const Marks& marks, std::uint32_t width, std::uint32_t height,
                       render::Picture& picture);

}  // namespace mote::server
