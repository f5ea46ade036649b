// SPDX-License-Identifier: GPL-3.0-or-later
//
// ParticleFile: particles in a new openPMD 1.1 file with the beam physics extension: group-based iterations,
// one species "beam", columns of f64 in m, eV/c, s. Each step is laid out, then its rows are written in any
// order. Nothing in it names the time or the machine. One owner, one thread.
//
// Known columns become the standard's records (position, momentum, time, weighting, weight, particleStatus,
// id), all others records of their own names. "weighting" counts real particles, "weight" is the charge of
// them: what of the two the column is, and the other where the charge of one is known. A column "time" that
// is not there is constant, the step's: a dump is of one moment.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "preprocess/openpmd/h5_output.h"
#include "protocol/base/error.h"

namespace mote::prep {

struct FileColumn {
    std::string name;  ///< "x", "px", "weight", or the source's own
    std::string unit;  ///< "m", "eV/c", "s", "1", ...
};

/// A step of the file. A value.
struct FileStep {
    std::int64_t iteration = 0;  ///< no other step has it
    double time = 0.0;           ///< s
    std::uint64_t rows = 0;
    std::vector<FileColumn> columns;
    bool ids = false;
    double mass = 0.0;       ///< eV/c^2, of one real particle; 0: not known
    std::string species;     ///< as SpeciesType has it; "": not known
    double charge = 0.0;     ///< C, of one real particle, with its sign; 0: not known, or neutral
    std::string weightUnit;  ///< of the column "weight": "1", "C"; "": not known
    /// Of all rows, where they are alike: whether they are lost. Nothing: the column "lost" says it (not 0:
    /// lost), or, without such a column, nobody does.
    std::optional<bool> lost = false;
};

class ParticleFile {
  public:
    /// An empty file over `path`. Errors: permissionDenied, resourceExhausted, internal; so of all below.
    static Result<ParticleFile> create(const std::filesystem::path& path);
    ParticleFile(ParticleFile&&) = default;
    ParticleFile& operator=(ParticleFile&&) = delete;
    /// Discards a file that was not closed.
    ~ParticleFile();

    /// The rows that are written next belong to it.
    Status begin(const FileStep& step);
    /// Rows [first, first + rows) of the present step: `columns` as the step has them, `ids` where it has
    /// any.
    Status write(std::uint64_t first, std::size_t rows, std::span<const std::vector<double>> columns,
                 const std::vector<std::uint64_t>& ids);
    /// Writes what HDF5 still holds back.
    Status close();

  private:
    explicit ParticleFile(const std::string& path);
    bool addWeights(hid_t species, const FileStep& step);
    bool addColumn(hid_t species, const FileStep& step, const FileColumn& column);
    bool describeSpecies(hid_t species, const FileStep& step) const;
    /// Says what is known of the step only when all is written.
    bool endStep();

    std::string name_;
    std::unique_ptr<H5Errors> errors_;  ///< outlives the file
    H5Handle file_;
    std::string species_;  ///< "/data/53/particles/beam"
    /// A record that a column is written to.
    struct Target {
        std::string path;     ///< within the species
        double factor = 1.0;  ///< of the column's values
    };
    std::vector<std::vector<Target>> targets_;  ///< by column
    std::optional<double> charge_;              ///< C, of the rows written so far; nothing: not known
    std::size_t weightColumn_ = 0;
    std::optional<std::size_t> statusColumn_;
    double weightUnit_ = 0.0;  ///< C, of one weight
};

}  // namespace mote::prep
