// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/synth/beam_columns.h"

namespace mote::prep {

BeamColumns::BeamColumns(std::size_t rows) : id(rows) {
    for (auto& column : position) column.resize(rows);
    for (auto& column : momentum) column.resize(rows);
}

void fillColumns(const ChannelPlan& plan, const ParticleArrays& particles, std::uint64_t first,
                 std::size_t begin, std::size_t end, BeamColumns& columns) {
    const double momentum = plan.beam.momentum;
    // zeta = gamma z, and zeta' = delta / gamma (docs/SYNTH.md).
    const std::array<double, 3> length{1.0, 1.0, 1.0 / plan.beam.gamma};
    const std::array<double, 3> scale{momentum, momentum, momentum * plan.beam.gamma};
    const std::array<double, 3> offset{0.0, 0.0, momentum};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t row = begin; row < end; ++row) {
            columns.position[axis][row] = static_cast<float>(length[axis] * particles.position[axis][row]);
            columns.momentum[axis][row] = offset[axis] + scale[axis] * particles.slope[axis][row];
        }
    }
    for (std::size_t row = begin; row < end; ++row) columns.id[row] = first + row;
}

}  // namespace mote::prep
