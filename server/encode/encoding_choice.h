// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which encoding a picture gets: lossless wherever the link carries it, H.264 below that, JPEG for clients
// without. JPEG is nowhere the best for others: smooth pictures, where it is good, H.264 packs still better.
// Pure; measured by bench-encode.
#pragma once

#include <cstddef>
#include <optional>

#include "protocol/mote.pb.h"

namespace mote::server {

/// What is known of one client, and of the link to it.
struct EncodingTarget {
    bool measured = false;  ///< it says what it receives; others get JPEG in motion, lossless at rest
    bool h264 = false;      ///< it decodes that
    /// What a frame in motion may hold, so that the link carries 30 a second; none: not measured yet.
    std::optional<std::size_t> frameBytes;
};

struct PictureFacts {
    bool exact = false;             ///< the picture at rest, or one that was asked for as such
    std::size_t losslessBytes = 0;  ///< expected
    bool wasLossless = false;       ///< the picture before it: a hand should not see it flicker
};

/// A frame's bytes until the link is measured: few enough for all but the thinnest.
inline constexpr std::size_t unmeasuredFrameBytes = 48 << 10;

proto::Frame::Encoding chooseEncoding(const EncodingTarget& target, const PictureFacts& picture);

}  // namespace mote::server
