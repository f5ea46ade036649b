// SPDX-License-Identifier: GPL-3.0-or-later
//
// SoftPoints: dots that fade in and out and glide to their places over a few pictures, instead of appearing,
// vanishing and jumping (section 2.2.5 of the dissertation). What is shown lags behind what is wanted, and
// reaches it. The state of one layer of one session; used by the thread that renders.
#pragma once

#include <vector>

#include "server/render/layers/stipple/surface_dots.h"

namespace mote::render {

class SoftPoints {
  public:
    static constexpr int pictures = 4;  ///< that a dot takes to appear or to vanish

    /// The next picture on the way to `wanted`, the points that `layer` sees. The first picture is there at
    /// once.
    const std::vector<ShownPoint>& step(const StippleSurface& surface, const SurfaceDots& layer,
                                        std::vector<ShownPoint> wanted);
    /// The end of the way.
    const std::vector<ShownPoint>& settle(std::vector<ShownPoint> wanted);

    /// Whether the latest picture showed what was wanted.
    bool settled() const { return settled_; }

  private:
    std::vector<ShownPoint> shown_;  // ascending by point
    bool settled_ = true;
};

}  // namespace mote::render
