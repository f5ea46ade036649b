// SPDX-License-Identifier: GPL-3.0-or-later
//
// The readers of particle files, one function a format, as openParticleSource chooses among them; that of
// tables with a line of names is in csv/csv_source.h. Called from one thread.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
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

// NumPy arrays: .npy files, with named fields or of shape N x 3, N x 6 or N x 7, and .npz archives, whose
// arrays are columns by their names.

/// Steps by their iterations where every file says them, else in the order of the numbers in the files'
/// names. `format` is what the source calls itself, "npy" or "npz"; `mass` in eV/c^2, 0: as the files say.
/// Errors: notFound, corrupt, unsupported, invalidArgument, resourceExhausted, cancelled.
Result<std::unique_ptr<ParticleSource>> openNpy(std::string format,
                                                const std::vector<std::filesystem::path>& files, double mass,
                                                Progress& progress);

// openPMD runs in HDF5 (versions 1.0 to 2.0, with or without the BeamPhysics extension), one or several
// files.

/// Opens all files as one series; `species` as in ParticlesJob, `mass` in eV/c^2, 0: as the files say.
/// Errors: notFound, unsupported, corrupt, invalidArgument (several species and none named; another mass than
/// the files say), cancelled.
Result<std::unique_ptr<ParticleSource>> openOpenpmd(const std::vector<std::filesystem::path>& files,
                                                    const std::string& species, double mass,
                                                    Progress& progress);

// SDDS data sets, as elegant writes them: text or binary pages, each a step, gzipped or not; and the same as
// sdds2hdf turns them into HDF5 (page1/columns/x). What becomes of each column: docs/READERS.md.

/// True where a group /page1/columns stands.
bool looksLikeSddsHdf5(const H5File& file);

/// Files in the order of the numbers in their names, pages as they stand. `format` is what the source calls
/// itself, "sdds" or "elegant" (HDF5); `mass` in eV/c^2, 0: the electron's where one is needed, with a note.
/// Errors: notFound, corrupt, unsupported, invalidArgument, cancelled.
Result<std::unique_ptr<ParticleSource>> openSdds(const std::string& format,
                                                 const std::vector<std::filesystem::path>& files, double mass,
                                                 Progress& progress);

// Distributions of TraceWin and PlotWin (.dst), one file a step.

bool looksLikeDst(std::string_view begin);

/// Steps in the order of the numbers in the files' names. `mass` in eV/c^2, 0: as the files say. Errors:
/// notFound, corrupt, unsupported (gzipped), invalidArgument (files of different masses), cancelled.
Result<std::unique_ptr<ParticleSource>> openDst(const std::vector<std::filesystem::path>& files, double mass,
                                                Progress& progress);

// Distributions of ASTRA: text of ten columns, relative to the first row, the reference particle; one file a
// step.

/// Whether the first row has ten numbers, of which the last two can be a species and a status.
bool looksLikeAstra(const std::filesystem::path& path);

/// Steps by the places in the files' names (100 of run.0100.001), else by their numbers. `mass` in eV/c^2, 0:
/// that of the species. Errors: notFound, corrupt, invalidArgument (files of different species), cancelled.
Result<std::unique_ptr<ParticleSource>> openAstra(const std::vector<std::filesystem::path>& files,
                                                  double mass, Progress& progress);

// Particle dumps of Genesis 1.3, version 4 (.par.h5): slices in one HDF5 file a step.

/// True where the datasets slicelength, slicespacing and beamletsize stand in the root.
bool looksLikeGenesis(const H5File& file);

/// Steps in the order of the numbers in the files' names. `mass` in eV/c^2, 0: the electron's. Errors:
/// notFound, corrupt, unsupported, cancelled.
Result<std::unique_ptr<ParticleSource>> openGenesis(const std::vector<std::filesystem::path>& files,
                                                    double mass, Progress& progress);

// Tracks of MAD-X and PTC in TFS (trackone, track.obs0001.p0001): a turn or segment a step.

/// Momenta by the header's PC, MASS, ... or the energies beside them. `mass` in eV/c^2, 0: as the files say.
/// Errors: notFound, corrupt, unsupported (no track, nothing that says the reference momentum),
/// resourceExhausted, cancelled.
Result<std::unique_ptr<ParticleSource>> openTfs(const std::vector<std::filesystem::path>& files, double mass,
                                                Progress& progress);

// JSON of named lists, as xsuite writes its particles; each object with such lists is a step.

/// `mass` in eV/c^2, 0: as the files say. Errors: notFound, corrupt, unsupported, resourceExhausted,
/// cancelled.
Result<std::unique_ptr<ParticleSource>> openJson(const std::vector<std::filesystem::path>& files, double mass,
                                                 Progress& progress);

// Outputs of GPT: GDF, and text with its names; a time or screen a step.

bool looksLikeGdf(std::string_view begin);
/// Whether one of the first lines names GPT's columns.
bool looksLikeGptText(const std::filesystem::path& path);

/// `mass` in eV/c^2, 0: as the files say, else the electron's, with a note. The same errors.
Result<std::unique_ptr<ParticleSource>> openGpt(const std::vector<std::filesystem::path>& files, double mass,
                                                Progress& progress);

// Archives of NumPy with an array p0c, in units of which their momenta are.

bool looksLikeScaledNpz(const std::filesystem::path& path);

/// Files in the order of the numbers in their names. `mass` in eV/c^2, 0: as the files say. The same errors.
Result<std::unique_ptr<ParticleSource>> openScaledNpz(const std::vector<std::filesystem::path>& files,
                                                      double mass, Progress& progress);

// Ocelot's particle arrays (.npz).

/// True for an archive with the arrays rparticles and E.
bool looksLikeOcelot(const std::filesystem::path& path);

/// Files in the order of the numbers in their names. `mass` in eV/c^2, 0: the electron's, with a note. The
/// same errors.
Result<std::unique_ptr<ParticleSource>> openOcelot(const std::vector<std::filesystem::path>& files,
                                                   double mass, Progress& progress);

// Distributions of OPAL in text, as FROMFILE takes and WRITETOFILE writes them; one file a step.

/// Whether a text begins as one with names: what has none is a table of numbers like others.
bool looksLikeOpal(std::string_view begin);

/// Steps in the order of the numbers in the files' names. `mass` in eV/c^2, 0: the electron's, with a note.
/// Errors: notFound, corrupt, unsupported (momenta that are no beta gamma), resourceExhausted, cancelled.
Result<std::unique_ptr<ParticleSource>> openOpal(const std::vector<std::filesystem::path>& files, double mass,
                                                 Progress& progress);

// Bunches of PyORBIT in text; one file a step.

bool looksLikePyorbit(std::string_view begin);

/// Steps in the order of the numbers in the files' names. `mass` in eV/c^2, 0: as the files say. Errors:
/// notFound, corrupt, unsupported (nothing that says the synchronous particle's momentum), resourceExhausted,
/// cancelled.
Result<std::unique_ptr<ParticleSource>> openPyorbit(const std::vector<std::filesystem::path>& files,
                                                    double mass, Progress& progress);

}  // namespace mote::prep
