// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/color_finder.h"

#include "server/render/cpu/value_sums.h"
#include "server/render/cpu/vectors.h"

namespace mote::render {

struct ColorFinder::State {
    ResidentLeaves leaves;
};

ColorFinder::ColorFinder() : state_(std::make_unique<State>()) {
    chooseVectors();
}

ColorFinder::~ColorFinder() = default;

std::optional<FrameColors> ColorFinder::find(const FramePlan& plan, const std::stop_token& stop) {
    return frameColors(plan, state_->leaves, stop);
}

void ColorFinder::dropExpired() {
    state_->leaves.dropExpired();
}

}  // namespace mote::render
