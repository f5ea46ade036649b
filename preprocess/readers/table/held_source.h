// SPDX-License-Identifier: GPL-3.0-or-later
//
// HeldSource: runs of formats that are read whole, as tables of named columns, a step each. A reader makes
// the tables of a file; what they mean says TableColumns. Owned as SeriesSource says; one thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/readers/particle_reader.h"
#include "preprocess/readers/table/table_source.h"
#include "preprocess/readers/text/row_file.h"
#include "protocol/base/error.h"

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

    void add(std::string name, std::vector<double> column) {
        names.push_back(std::move(name));
        values.push_back(std::move(column));
    }
    /// A column that says nothing of particles' coordinates: a record of the source, if it has a value for
    /// each row. Behind a column that does.
    void addUnknown(const std::string& name, std::vector<double> column);
    /// The constant `mass` in eV/c^2, of the electron where it is 0, then with a note that begins with `who`.
    double setMass(double mass, const std::string& who);
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

/// A file of a run that is read whole.
struct HeldFile {
    const std::filesystem::path& path;
    double mass;  ///< eV/c^2, as the job says; 0: it does not
    HeldNumbers& held;
    Progress& progress;

    std::string name() const { return path.filename().string(); }
    /// The whole of a text file, gzipped or not. Errors: those of wholeFile.
    Result<std::string> text() const;
};

/// Gives each line of a file to `parser.line(text, where)`. Errors: those of eachLine and of the parser.
template <class Parser>
Status parseLines(const HeldFile& file, Parser& parser) {
    return eachLine(file.path, file.progress, [&](std::string_view text, const std::string& where) {
        return parser.line(text, where);
    });
}

class HeldSource : public TableSource {
  protected:
    HeldSource(std::string format, double mass, Progress& progress)
        : TableSource(std::move(format), progress), wantedMass_(mass) {}

    HeldFile fileAt(const std::filesystem::path& path) { return {path, wantedMass_, held_, progress_}; }
    bool anyRead() const override { return !tables_.empty(); }
    /// Puts the tables in order of their iterations where all have one, and reads their columns. Errors:
    /// those of TableColumns::of, corrupt (columns of different lengths), notFound (no table).
    Status finish() override;
    Status readRows(std::size_t step, const std::vector<Column>& wanted, ParticleChunk& chunk) override;

    std::vector<HeldTable> tables_;

  private:
    Status addTable(const HeldTable& table, std::set<std::string>& notes);
    void readIds(std::size_t step, ParticleChunk& chunk) const;

    double wantedMass_;
    HeldNumbers held_;
};

/// Each file's tables, or its one table, by a function; a file of one table is numbered by its name where
/// there are several files. Errors: those of the function and of HeldSource::finish, cancelled.
using TablesOfFile = std::function<Result<std::vector<HeldTable>>(const HeldFile& file)>;
Result<std::unique_ptr<ParticleSource>> openHeld(std::string format, TablesOfFile tablesOf,
                                                 const AskedRun& run, Progress& progress);
Result<std::unique_ptr<ParticleSource>> openHeld(std::string format,
                                                 Result<HeldTable> (*tableOf)(const HeldFile& file),
                                                 const AskedRun& run, Progress& progress);

}  // namespace mote::prep
