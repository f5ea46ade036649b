// SPDX-License-Identifier: GPL-3.0-or-later
//
// Tables of small formats as runs: read whole, at most 1 GiB of numbers, since their rows lie in other orders
// than a run's (a file a particle, a step a turn). Values are owned by the source that is made of them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "preprocess/readers/particle_source.h"
#include "preprocess/readers/table/table_columns.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// One step's table.
struct HeldTable {
    std::string where;                        ///< "track.tfs", for messages
    std::optional<std::int64_t> iteration;    ///< nothing: its place among the others
    double time = 0.0;                        ///< s
    std::vector<std::string> names;           ///< with units, as TableColumns reads them
    std::vector<std::vector<double>> values;  ///< by name, all of one length
    std::vector<TableConstant> constants;
    std::vector<std::string> notes;
};

/// How many numbers are held of a run; the count of all its files. One owner.
class HeldNumbers {
  public:
    static constexpr std::uint64_t most = 1ull << 27;

    /// Counts more of them. Error, at `where`: resourceExhausted.
    Status add(std::uint64_t numbers, const std::string& where);

  private:
    std::uint64_t count_ = 0;
};

/// The whole of a text file, gzipped or not. Errors: those of ByteSource, resourceExhausted (more than 1
/// GiB).
Result<std::string> readText(const std::filesystem::path& path);

/// The tables as a run, in order of their iterations where all have one, else as they stand. `mass` in
/// eV/c^2, 0: as the tables say. Errors: those of TableColumns::of, corrupt (columns of different lengths),
/// notFound (no table).
Result<std::unique_ptr<ParticleSource>> holdTables(std::string format, std::vector<HeldTable> tables,
                                                   double mass, Progress& progress);

}  // namespace mote::prep
