// SPDX-License-Identifier: GPL-3.0-or-later
//
// The readers of particle files, one function a format, as openParticleSource chooses among them; that of
// tables with a line of names is in csv/csv_source.h. Called from one thread.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "preprocess/readers/impact/impact_deck.h"
#include "preprocess/readers/particle_source.h"

namespace mote::prep {

// H5Part runs: HDF5 files whose groups Step#0, Step#1, ... hold one dataset a column, as OPAL and others
// write.

class H5File;

/// True where a group Step#N stands in the root.
bool looksLikeH5Part(const H5File& file);

/// All files as one series. `mass` in eV/c^2, 0: as the file says. Errors: notFound, unsupported, corrupt,
/// cancelled.
Result<std::unique_ptr<ParticleSource>> openH5Part(const std::vector<std::filesystem::path>& files,
                                                   double mass, Progress& progress);

// Particle files of IMPACT-Z (nine columns, scaled by the frequency, relative to the reference particle) and
// of IMPACT-T (six columns). One file a step, gzipped or not. What the units of each column are:
// docs/READERS.md.

/// Steps in the order of the numbers in the files' names. Units and mass from `options`, else from a deck
/// beside the first file. Errors: notFound, corrupt, invalidArgument (a unit that is not known), cancelled.
Result<std::unique_ptr<ParticleSource>> openImpact(ImpactDeck::Code code,
                                                   const std::vector<std::filesystem::path>& files,
                                                   const proto::ImpactOptions& options, Progress& progress);

// NumPy arrays: one .npy file a step, with named fields or of shape N x 6 or N x 7.

/// Steps in the order of the numbers in the files' names. `mass` in eV/c^2, 0: unknown. Errors: notFound,
/// corrupt, unsupported, invalidArgument, cancelled.
Result<std::unique_ptr<ParticleSource>> openNpy(const std::vector<std::filesystem::path>& files, double mass,
                                                Progress& progress);

// openPMD runs in HDF5 (versions 1.0 to 2.0, with or without the BeamPhysics extension), one or several
// files.

/// Opens all files as one series; `species` as in ParticlesJob. Errors: notFound, unsupported, corrupt,
/// invalidArgument (several species and none named), cancelled.
Result<std::unique_ptr<ParticleSource>> openOpenpmd(const std::vector<std::filesystem::path>& files,
                                                    const std::string& species, Progress& progress);

// SDDS data sets, as elegant writes them: text or binary pages, each a step, gzipped or not. What becomes of
// each column: docs/READERS.md.

/// Files in the order of the numbers in their names, pages as they stand. `mass` in eV/c^2, 0: the electron's
/// where one is needed, with a note. Errors: notFound, corrupt, unsupported, invalidArgument, cancelled.
Result<std::unique_ptr<ParticleSource>> openSdds(const std::vector<std::filesystem::path>& files, double mass,
                                                 Progress& progress);

}  // namespace mote::prep
