// SPDX-License-Identifier: GPL-3.0-or-later
//
// ColorFinder: finds the colours of the pixels of layers that are coloured by a column, on the processor, for
// a device that does not. Owned by the device; one thread, which uses all threads of the calling arena.
#pragma once

#include <memory>
#include <optional>
#include <stop_token>

#include "server/render/plan/frame_plan.h"
#include "server/render/plan/pixel_colors.h"

namespace mote::render {

class ColorFinder {
  public:
    ColorFinder();
    ~ColorFinder();
    ColorFinder(const ColorFinder&) = delete;
    ColorFinder& operator=(const ColorFinder&) = delete;

    /// Nothing where `stop` was requested meanwhile. Throws storage::StorageError.
    std::optional<FrameColors> find(const FramePlan& plan, const std::stop_token& stop);
    /// Frees what it keeps of steps that nobody else holds any more.
    void dropExpired();

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace mote::render
