// SPDX-License-Identifier: GPL-3.0-or-later
//
// LayersBetween: what the layers of one view become on their way to those of another (docs/SCRIPTS.md,
// "Films"). A value; safe on any number of threads.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "protocol/scene/film/steps_between.h"
#include "protocol/scene/view.h"

namespace mote {

/// Whether a layer can be between two steps; of others one is shown.
bool blendsSteps(const Layer& layer);

class LayersBetween {
  public:
    LayersBetween(const std::vector<Layer>& from, const std::vector<Layer>& to, BetweenSteps betweenSteps);

    /// How many there are at most at any time between.
    std::size_t mostLayers() const;
    /// At a share of the way, more than 0 and less than 1. Their weights over those of both views add up to
    /// what they are between them.
    std::vector<Layer> at(double share) const;

  private:
    struct Pair {
        const Layer* from = nullptr;  ///< null: it comes
        const Layer* to = nullptr;    ///< null: it goes
        bool dissolves = false;       ///< something has nothing in between: both are shown
    };
    void match(const std::vector<Layer>& from, const std::vector<Layer>& to);
    BetweenSteps stepsOf(const Pair& pair) const;

    std::vector<Pair> pairs_;  // of layers that whoever owns them keeps
    BetweenSteps betweenSteps_;
};

/// At a share of the way between the annotations of two views, more than 0 and less than 1: what has nothing
/// in between is as in the first.
std::optional<proto::Annotations> mixAnnotations(std::optional<proto::Annotations> from,
                                                 const std::optional<proto::Annotations>& to, double share);

}  // namespace mote
