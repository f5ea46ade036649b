// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/quantized_step.h"

#include <oneapi/tbb/parallel_for.h>

namespace mote::prep {
namespace {

bool contains(const Range& range, double value) {
    return value >= range.min && value <= range.max;
}

std::uint32_t fraction(const Range& range, double value) {
    // The division first: multiplying by 2^32 is then exact, so that the cell of any level is the same as the
    // one that floor(2^level (value - min) / (max - min)) gives.
    const double scaled = (value - range.min) / (range.max - range.min) * 0x1p32;
    return scaled >= 0x1p32 ? 0xffffffffU : static_cast<std::uint32_t>(scaled);
}

bool isInside(const StepParticles& particles, const std::array<Range, 3>& bounds, std::size_t i) {
    return contains(bounds[0], particles.coordinate[0][i]) &&
           contains(bounds[1], particles.coordinate[1][i]) && contains(bounds[2], particles.coordinate[2][i]);
}

/// Drops particles beyond the bounds, keeping the order; how many.
std::uint64_t dropOutside(StepParticles& particles, const std::array<Range, 3>& bounds) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < particles.size(); ++i) {
        if (!isInside(particles, bounds, i)) continue;
        if (kept != i) {
            for (auto& values : particles.coordinate) values[kept] = values[i];
            particles.weight[kept] = particles.weight[i];
            particles.row[kept] = particles.row[i];
        }
        ++kept;
    }
    const std::uint64_t dropped = particles.size() - kept;
    for (auto& values : particles.coordinate) values.resize(kept);
    particles.weight.resize(kept);
    particles.row.resize(kept);
    return dropped;
}

}  // namespace

QuantizedStep quantize(StepParticles particles, const std::array<Range, 3>& bounds) {
    QuantizedStep step;
    step.outside = dropOutside(particles, bounds);
    step.place.resize(particles.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, particles.size(), 1 << 14), [&](const auto& part) {
        for (std::size_t i = part.begin(); i < part.end(); ++i) {
            for (std::size_t a = 0; a < 3; ++a) {
                step.place[i][a] = fraction(bounds[a], particles.coordinate[a][i]);
            }
        }
    });
    step.weight = std::move(particles.weight);
    step.row = std::move(particles.row);
    return step;
}

}  // namespace mote::prep
