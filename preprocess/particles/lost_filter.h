// SPDX-License-Identifier: GPL-3.0-or-later
//
// LostFilter: a run of which a plot takes the particles that its source marks as lost, or only these: seen
// through it, what takes no part is what is marked. Used from one thread at a time; the source outlives it.
#pragma once

#include <string>
#include <vector>

#include "preprocess/readers/particle_source.h"

namespace mote::prep {

enum class LostParticles : std::uint8_t { without, with, only };

/// Errors: invalidArgument, at "lost".
Result<LostParticles> parseLostParticles(const std::string& text);

/// What the source has settled, else what the request says; `without` if that is wrong.
LostParticles lostParticlesOf(const ParticleSource& source, const proto::ParticlesJob& job);

/// Whether a particle with this mark takes part.
constexpr bool takesPart(LostParticles choice, bool lost) {
    return choice == LostParticles::with || lost == (choice == LostParticles::only);
}

class LostFilter final : public ParticleSource {
  public:
    LostFilter(ParticleSource& source, LostParticles choice) : source_(&source), choice_(choice) {}

    std::string format() const override { return source_->format(); }
    const std::vector<SourceStep>& steps() const override { return source_->steps(); }
    bool has(Column column) const override { return source_->has(column); }
    std::vector<SourceRecord> records() const override { return source_->records(); }
    double mass() const override { return source_->mass(); }
    std::string species() const override { return source_->species(); }
    double particleCharge() const override { return source_->particleCharge(); }
    std::string weightUnit() const override { return source_->weightUnit(); }
    bool readsAtOnce(std::size_t step) const override { return source_->readsAtOnce(step); }
    std::uint64_t keptBytes(std::size_t step, std::size_t threads) const override {
        return source_->keptBytes(step, threads);
    }
    Status read(std::size_t step, std::uint64_t begin, std::size_t count, const std::vector<Column>& wanted,
                ParticleChunk& chunk) override;

  private:
    ParticleSource* source_;
    LostParticles choice_;
};

}  // namespace mote::prep
