// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the panes of a window do together: steps, selections, cameras. What the hand changes in one of them is
// carried over to the others at the end of a frame; what came by itself (a file, undo, a film) is not. Main
// thread; no window.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "client/view/numbers/numbers_model.h"
#include "protocol/scene/camera.h"

namespace mote::client {

class ViewModel;

struct Links {
    bool steps = true;       ///< each goes to the same step, or to its last
    bool selections = true;  ///< those of one run have the same, and highlight the same
    bool cameras = false;
    bool operator==(const Links&) const = default;
};

/// What links carry over of a view.
struct LinkedParts {
    std::uint32_t step = 0;  ///< of the layer whose steps are played
    SelectionsShown selections;
    std::optional<Camera> camera;  ///< nothing: fitted
};

class LinkedViews {
  public:
    /// Carries over what changed in the active view since the last time. Another active view, or another in
    /// its place, is where that begins. Returns which of the others changed.
    std::vector<std::size_t> follow(const ViewModel& active, std::span<ViewModel* const> others,
                                    const Links& links);

  private:
    const ViewModel* of_ = nullptr;
    std::uint64_t jumps_ = 0;
    int chosen_ = 0, layers_ = 0;
    LinkedParts seen_;
};

/// Carries all of it over, as links say, where they are made. Returns which changed.
std::vector<std::size_t> shareAll(const ViewModel& active, std::span<ViewModel* const> others,
                                  const Links& links);

/// Where a view cannot go along: the step at which it stays, its last, though the active one is further on.
std::optional<std::uint32_t> heldStep(const ViewModel& view, const ViewModel& active);

}  // namespace mote::client
