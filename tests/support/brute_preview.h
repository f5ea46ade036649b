// SPDX-License-Identifier: GPL-3.0-or-later
//
// The preview of any step, by sorting all of its points: slow, and of no code that mote-prep uses. A pure
// function.
#pragma once

#include <vector>

#include "storage/particles/particle_step.h"

namespace mote::test {

struct BrutePreview {
    std::vector<storage::PreviewPoint> points;
    std::vector<float> threshold;
    LogDensity scale;

    /// As ParticleStep::preview.
    storage::Preview first(std::uint64_t most) const;
};

BrutePreview brutePreview(const storage::ParticleStep& step);

}  // namespace mote::test
