// SPDX-License-Identifier: GPL-3.0-or-later
//
// Several species of a run as one: the rows of the first, of the second, and so on, in every iteration that
// any of them has. What tells them apart becomes columns: "species", their place in the order in which they
// were named; "mass" (eV/c^2) and "particle_charge" (C, with its sign) where these differ: then the run has
// no one mass, of which energies and gammas are made from the column (known_quantity.h), and normalised
// emittances are not defined; nor has it one charge, and of weights that count particles no total charge is
// made. Ids of the species N have N in their highest byte (exclusive or): no two particles have the same,
// and those of the first are the source's own.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/readers/particle_source.h"
#include "protocol/base/error.h"

namespace mote::prep {

constexpr std::size_t mostSpecies = 64;  ///< in one plot

/// Puts the name of a species before each note of it.
class SpeciesNotes final : public Progress {
  public:
    SpeciesNotes(std::string name, Progress& progress) : name_(std::move(name)), progress_(progress) {}
    void report(double fraction, std::string_view phase) override { progress_.report(fraction, phase); }
    void note(std::string_view sentence) override { progress_.note(name_ + ": " + std::string(sentence)); }
    bool cancelled() const override { return progress_.cancelled(); }

  private:
    std::string name_;
    Progress& progress_;
};

/// One species, opened by itself.
struct SpeciesPart {
    std::string name;
    std::unique_ptr<SpeciesNotes> notes;     ///< to which the source speaks
    std::unique_ptr<ParticleSource> source;  ///< not null
};

/// "NAME" or "NAME,NAME", as ParticlesJob::species has it; one name, which may be empty, stays as it is.
/// Errors: invalidArgument at "species": none between commas, one twice, more than mostSpecies.
Result<std::vector<std::string>> namesOfSpecies(const std::string& text);

/// The parts as one run, two at least, of one format. What is left out, and how the species are told apart,
/// goes to `progress`, which outlives the source. Errors: invalidArgument (weights that count particles
/// beside weights that are charges).
Result<std::unique_ptr<ParticleSource>> joinSpecies(std::vector<SpeciesPart> parts, Progress& progress);

}  // namespace mote::prep
