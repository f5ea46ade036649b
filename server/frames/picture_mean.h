// SPDX-License-Identifier: GPL-3.0-or-later
//
// PictureMean: the mean of several finished pictures of one size, in linear light. A value of the thread that
// renders.
#pragma once

#include <cstdint>
#include <optional>

#include "server/render/plan/picture.h"

namespace mote::server {

class PictureMean {
  public:
    /// A picture of linear halves, as large as the others. Weights add up to 1 in the end.
    void add(render::Picture picture, double weight);
    /// Of two pictures to a rounding of the format, of more to one of a half besides. What was added is gone.
    render::Picture take(render::PixelFormat format);
    std::uint64_t bytes() const;

  private:
    struct Weighted {
        render::Picture picture;
        double weight;
    };
    void join();

    std::optional<Weighted> sum_, latest_;
};

}  // namespace mote::server
