// SPDX-License-Identifier: GPL-3.0-or-later
//
// ParticleSource: a particle run in a foreign format, as a series of steps with columns in one set of units.
// Owned by the job; used from one thread at a time. Untrusted bytes become Errors that name file, record and
// position; no size that a file declares is believed before it is checked against the file.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "preprocess/job.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::prep {

/// The columns of a run, after units are applied.
enum class Column : std::uint8_t {
    x,
    y,
    z,  ///< m
    t,  ///< s
    px,
    py,
    pz,      ///< eV/c, of one real particle (not of the macro-particle)
    weight,  ///< real particles that a macro-particle stands for, or the magnitude of its charge in C; >= 0
    id,      ///< the source's own; the row where it has none
};
inline constexpr std::size_t columnCount = 9;

/// What else a run has of each particle, in every step: by the source's own name, in its unit.
struct SourceRecord {
    std::string name, unit;
    bool kept = false;  ///< beside the points of a plot, unless its columns are named
};
inline constexpr std::size_t mostRecords = 64;
constexpr bool isRecord(Column column) {
    return static_cast<std::size_t>(column) >= columnCount;
}
/// The column of a run's record: those come behind the others.
constexpr Column recordColumn(std::size_t record) {
    return static_cast<Column>(columnCount + record);
}

constexpr bool isMomentum(Column column) {
    return column == Column::px || column == Column::py || column == Column::pz;
}

/// One step of the run.
struct SourceStep {
    std::string file;             ///< where it stands, for messages
    std::int64_t iteration = 0;   ///< the source's own number
    double time = 0.0;            ///< s; 0 where the source does not say
    std::uint64_t particles = 0;  ///< rows, lost ones included
};

/// Rows [begin, begin + size) of a step. Only the columns that were asked for are filled.
struct ParticleChunk {
    std::uint64_t begin = 0;
    std::size_t size = 0;
    std::array<std::vector<double>, columnCount + mostRecords> columns;  ///< by Column; of id none
    std::vector<std::uint64_t> id;
    std::vector<std::uint8_t> lost;  ///< 1 where the source marks the particle as lost

    std::vector<double>& operator[](Column column) { return columns[static_cast<std::size_t>(column)]; }
    const std::vector<double>& operator[](Column column) const {
        return columns[static_cast<std::size_t>(column)];
    }
};

class ParticleSource {
  public:
    virtual ~ParticleSource() = default;
    virtual std::string format() const = 0;  ///< as in --format
    virtual const std::vector<SourceStep>& steps() const = 0;
    /// Whether the run has the column, in every step.
    virtual bool has(Column column) const = 0;
    /// What it has besides, at most mostRecords; names differ from those of all known quantities.
    virtual std::vector<SourceRecord> records() const { return {}; }
    /// Rest mass of one real particle, eV/c^2; 0 where the source does not say.
    virtual double mass() const = 0;
    /// What the particles are, as openPMD's SpeciesType has it ("electron", "positron", "#12C+3"); "" where
    /// the source does not say.
    virtual std::string species() const { return ""; }
    /// Charge of one real particle in C, with its sign; 0 where the source does not say, and of neutral ones.
    virtual double particleCharge() const { return 0.0; }
    /// What weights count: "1" real particles, "C" charge; "" where the source does not say.
    virtual std::string weightUnit() const { return ""; }
    /// What it holds of particles that are lost, where that is settled: "without", "with" or "only"; "": it
    /// marks them.
    virtual std::string lostParticles() const { return ""; }
    /// A step's statistics by mote::statistics(), where the source keeps them; else none.
    virtual std::vector<double> statistics(std::size_t) const { return {}; }
    /// Whether several threads may read() rows of a step at once; else one call comes after another.
    virtual bool readsAtOnce(std::size_t) const { return false; }
    /// Bytes that it keeps, at most, while so many threads read a step: what was decoded last of each column.
    virtual std::uint64_t keptBytes(std::size_t, std::size_t) const { return 0; }
    /// Reads rows [begin, begin + count) of a step, `count` at most 2^22. Missing weights are 1, missing ids
    /// the row.
    virtual Status read(std::size_t step, std::uint64_t begin, std::size_t count,
                        const std::vector<Column>& wanted, ParticleChunk& chunk) = 0;
};

/// Opens all of a job's inputs (paths of the file system) as one run, in the order of their steps: format by
/// `job.format()` or by content, species, IMPACT options from `job`. Steps are not yet selected. A name with
/// %T or %06T stands for all files of such names. What a user should know (defaults taken, a deck found
/// beside the file) goes to `progress.note`; `progress` must outlive the source, which asks it whether to
/// stop. Errors: notFound, unsupported (an ADIOS2 file, an unknown format), corrupt, invalidArgument,
/// cancelled.
Result<std::unique_ptr<ParticleSource>> openParticleSource(const proto::ParticlesJob& job,
                                                           const std::vector<std::filesystem::path>& inputs,
                                                           Progress& progress);

}  // namespace mote::prep
