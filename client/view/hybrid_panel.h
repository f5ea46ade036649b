// SPDX-License-Identifier: GPL-3.0-or-later
//
// The part of the panel that edits a hybrid volume. Main thread, within the panel's window.
#pragma once

#include "client/view/hybrid_controls.h"
#include "client/view/panel.h"

namespace mote::client {

/// What the volume is and what is drawn of it, in a few faint lines; `step` of its steps.
void drawHybridFacts(const proto::Manifest& manifest, std::uint32_t step, const HybridControls& controls);

/// `eye` in the volume's world: new clip planes face it.
void drawHybrid(HybridControls& controls, const proto::HybridManifest& manifest, std::uint32_t step,
                const glm::dvec3& eye, PanelActions& actions, float scale);

}  // namespace mote::client
