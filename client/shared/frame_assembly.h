// SPDX-License-Identifier: GPL-3.0-or-later
//
// FrameAssembly: the pieces of a frame become the frame again. The server may leave a frame unfinished and go
// on with another. One owner, one thread at a time.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::client {

/// A frame with all of its payload.
struct WholeFrame {
    proto::Frame message;
    std::vector<std::uint8_t> payload;
};

class FrameAssembly {
  public:
    /// Nothing where more pieces are to come. Errors: corrupt (a piece of no frame, or of another place in
    /// it).
    Result<std::optional<WholeFrame>> add(proto::Frame message, std::vector<std::uint8_t> payload);

  private:
    std::optional<WholeFrame> open_;
};

}  // namespace mote::client
