// SPDX-License-Identifier: GPL-3.0-or-later
//
// Holds a dataset to its source, particle by particle, with its own plain arithmetic.
#pragma once

#include <filesystem>

#include "preprocess/readers/particle_source.h"
#include "protocol/mote.pb.h"

namespace mote::test {

/// Fails the test unless every particle of every selected step is in exactly one leaf, at its place to within
/// the leaf's cell / 65536, or counted as lost, invalid or outside; unless all densities are what the
/// particles say, and the volume is an independent histogram.
void expectAccounted(const std::filesystem::path& dataset, const proto::ParticlesJob& job,
                     prep::ParticleSource& source);

}  // namespace mote::test
