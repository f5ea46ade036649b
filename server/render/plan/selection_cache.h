// SPDX-License-Identifier: GPL-3.0-or-later
//
// A SelectionCache keeps the latest point selections, so that a camera that moves around the same points
// computes them once. Owned by whoever makes plans; one thread. It holds no step alive.
#pragma once

#include <cstddef>
#include <list>
#include <memory>

#include "server/render/plan/point_selection.h"

namespace mote::render {

class SelectionCache {
  public:
    /// Throws as selectPoints.
    std::shared_ptr<const PointSelection> of(const std::shared_ptr<const storage::ParticleStep>& step,
                                             const Curve& pointFraction, double share);

  private:
    static constexpr std::size_t kept = 4;  // quick, intermediate and exact of one style, and one more

    struct Entry {
        std::weak_ptr<const storage::ParticleStep> step;
        Curve pointFraction;
        double share;
        std::shared_ptr<const PointSelection> selection;
    };
    std::list<Entry> entries_;  // the latest first
};

}  // namespace mote::render
