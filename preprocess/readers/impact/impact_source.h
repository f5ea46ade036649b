// SPDX-License-Identifier: GPL-3.0-or-later
//
// Particle files of IMPACT-Z (nine columns, scaled by the frequency, relative to the reference particle) and
// of IMPACT-T (six columns). One file a step, gzipped or not. What the units of each column are:
// docs/READERS.md.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "preprocess/readers/impact/impact_deck.h"
#include "preprocess/readers/particle_source.h"

namespace mote::prep {

/// Steps in the order of the numbers in the files' names. Units and mass from `options`, else from a deck
/// beside the first file. Errors: notFound, corrupt, invalidArgument (a unit that is not known), cancelled.
Result<std::unique_ptr<ParticleSource>> openImpact(ImpactDeck::Code code,
                                                   const std::vector<std::filesystem::path>& files,
                                                   const proto::ImpactOptions& options, Progress& progress);

}  // namespace mote::prep
