// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/file_number.h"
#include "preprocess/readers/impact/number_table.h"
#include "preprocess/readers/known_species.h"
#include "preprocess/readers/odd_steps.h"
#include "preprocess/readers/particle_formats.h"
#include "preprocess/readers/text/number.h"
#include "preprocess/readers/text/row_file.h"

namespace mote::prep {
namespace {

using Row = std::array<double, NumberTable::maxColumns>;

// Columns of a file, from 0, and their units: m, eV/c, ns, nC.
constexpr std::size_t xColumn = 0, yColumn = 1, zColumn = 2, pxColumn = 3, pyColumn = 4, pzColumn = 5,
                      clockColumn = 6, chargeColumn = 7, speciesColumn = 8, statusColumn = 9,
                      columnsOfFile = 10;
constexpr double nano = 1e-9;
constexpr double mostSpecies = 14;
constexpr std::uint64_t maxProbedLines = 10'000;
/// A particle of status -1 to -6 waits at the cathode; one below is lost.
constexpr double lastWaiting = -6, leastStatus = -1000, mostStatus = 1000;

constexpr std::uint32_t bit(std::size_t column) {
    return 1u << column;
}
constexpr std::uint32_t allBits = bit(columnsOfFile) - 1;

/// By ASTRA's number of the species; nothing known: the user defines it in the run's input.
KnownSpecies ofNumber(double species) {
    static constexpr const char* names[] = {"electron", "positron", "proton", "h-"};
    return species >= 1 && species <= 4 ? *speciesOf(names[static_cast<int>(species) - 1]) : KnownSpecies();
}

bool whole(double value, double least, double most) {
    return value >= least && value <= most && value == std::floor(value);
}

bool looksLikeParticle(const Row& row) {
    return whole(row[speciesColumn], 1, mostSpecies) && whole(row[statusColumn], leastStatus, mostStatus);
}

/// The place of a dump in cm, 100 of "run.0100.001"; else the number in the file's name.
std::optional<std::int64_t> stepNumber(const std::filesystem::path& path) {
    const std::string name = path.filename().string();
    const std::size_t run = name.rfind('.');
    const std::size_t place = run == std::string::npos || run == 0 ? run : name.rfind('.', run - 1);
    if (place == std::string::npos || place == run) return fileNumber(path);
    std::int64_t number = 0, runNumber = 0;
    const char* const end = name.data() + name.size();
    const bool both =
        std::from_chars(name.data() + place + 1, name.data() + run, number).ptr == name.data() + run &&
        std::from_chars(name.data() + run + 1, end, runNumber).ptr == end && place + 1 < run;
    return both ? std::optional(number) : fileNumber(path);
}

std::vector<std::filesystem::path> inStepOrder(std::vector<std::filesystem::path> files) {
    std::set<std::int64_t> numbers;
    for (const auto& file : files) {
        if (const auto number = stepNumber(file)) numbers.insert(*number);
    }
    if (numbers.size() == files.size()) {
        std::sort(files.begin(), files.end(),
                  [](const auto& a, const auto& b) { return *stepNumber(a) < *stepNumber(b); });
    }
    return files;
}

class AstraSource : public ParticleSource {
  public:
    AstraSource(double mass, Progress& progress) : mass_(mass), progress_(progress) {}
    Status addFile(const std::filesystem::path& path);

    std::string format() const override { return "astra"; }
    const std::vector<SourceStep>& steps() const override { return steps_; }
    bool has(Column column) const override { return column != Column::id; }
    double mass() const override { return mass_; }
    std::string species() const override { return ofNumber(species_.value_or(0.0)).name; }
    double particleCharge() const override { return ofNumber(species_.value_or(0.0)).charge; }
    std::string weightUnit() const override { return has(Column::weight) ? "C" : ""; }
    Status read(std::size_t step, std::uint64_t begin, std::size_t count, const std::vector<Column>& wanted,
                ParticleChunk& chunk) override;

  private:
    struct Dump {
        NumberTable table;
        double z = 0, pz = 0, clock = 0;  // of the reference particle, in the file's units
    };

    Status setMass(const Row& reference, const std::string& file);
    static std::uint32_t needed(const std::vector<Column>& wanted);
    static double value(Column column, const Row& row, const Dump& dump, bool reference);

    double mass_;
    Progress& progress_;
    std::optional<double> species_;
    std::vector<SourceStep> steps_;
    std::vector<Dump> dumps_;
    std::size_t open_ = 0;
};

Status AstraSource::addFile(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(auto table, NumberTable::open(path, columnsOfFile, progress_));
    const std::string name = path.filename().string();
    Dump dump{std::move(table)};
    SourceStep step{name, stepNumber(path).value_or(static_cast<std::int64_t>(steps_.size())), 0.0,
                    dump.table.rows()};
    if (dump.table.rows() > 0) {
        Row row{};
        MOTE_RETURN_IF_ERROR(dump.table.seek(0, progress_));
        MOTE_RETURN_IF_ERROR(dump.table.next(allBits, row));
        if (!looksLikeParticle(row)) {
            return Error{ErrorCode::corrupt, name,
                         "is no ASTRA distribution: columns 9 and 10 of its first row are no species (1 to "
                         "14) and status"};
        }
        dump.z = row[zColumn];
        dump.pz = row[pzColumn];
        dump.clock = row[clockColumn];
        step.time = std::isfinite(dump.clock) ? dump.clock * nano : 0.0;
        MOTE_RETURN_IF_ERROR(setMass(row, name));
        dump.table.close();
    }
    steps_.push_back(std::move(step));
    dumps_.push_back(std::move(dump));
    return success();
}

Status AstraSource::setMass(const Row& reference, const std::string& file) {
    const double species = reference[speciesColumn];
    if (species_ && *species_ != species) {
        return Error{ErrorCode::invalidArgument, file,
                     "has particles of another species than the first file"};
    }
    if (!species_ && mass_ <= 0.0) {
        mass_ = ofNumber(species).mass;
        if (mass_ == 0.0) {
            progress_.note("the mass of species " + std::to_string(static_cast<int>(species)) +
                           " stands in ASTRA's input, not in the file: give it (impact.mass of the job)");
        }
    }
    species_ = species;
    return success();
}

std::uint32_t AstraSource::needed(const std::vector<Column>& wanted) {
    static constexpr std::size_t columns[] = {xColumn,  yColumn,  zColumn,  clockColumn,
                                              pxColumn, pyColumn, pzColumn, chargeColumn};
    std::uint32_t bits = bit(statusColumn);
    for (const Column column : wanted) {
        if (column != Column::id) bits |= bit(columns[static_cast<std::size_t>(column)]);
    }
    return bits;
}

/// z, pz and clock of all but the reference particle are relative to it.
double AstraSource::value(Column column, const Row& row, const Dump& dump, bool reference) {
    const double share = reference ? 0.0 : 1.0;
    switch (column) {
        case Column::x:
            return row[xColumn];
        case Column::y:
            return row[yColumn];
        case Column::z:
            return row[zColumn] + share * dump.z;
        case Column::t:
            return (row[clockColumn] + share * dump.clock) * nano;
        case Column::px:
            return row[pxColumn];
        case Column::py:
            return row[pyColumn];
        case Column::pz:
            return row[pzColumn] + share * dump.pz;
        case Column::weight:
            return std::abs(row[chargeColumn]) * nano;
        case Column::id:
            break;
    }
    return 0.0;
}

Status AstraSource::read(std::size_t step, std::uint64_t begin, std::size_t count,
                         const std::vector<Column>& wanted, ParticleChunk& chunk) {
    MOTE_RETURN_IF_ERROR(checkRange(steps_, step, begin, count));
    if (open_ != step) dumps_[open_].table.close();
    open_ = step;
    Dump& dump = dumps_[step];
    MOTE_RETURN_IF_ERROR(dump.table.seek(begin, progress_));
    chunk.begin = begin;
    chunk.size = count;
    chunk.lost.assign(count, 0);
    for (const Column column : wanted) {
        if (column == Column::id)
            chunk.id.resize(count);
        else
            chunk[column].resize(count);
    }
    Row row{};
    const std::uint32_t bits = needed(wanted);
    for (std::size_t i = 0; i < count; ++i) {
        MOTE_RETURN_IF_ERROR(dump.table.next(bits, row));
        chunk.lost[i] = row[statusColumn] < lastWaiting ? 1 : 0;
        for (const Column column : wanted) {
            if (column == Column::id)
                chunk.id[i] = begin + i;
            else
                chunk[column][i] = value(column, row, dump, begin + i == 0);
        }
    }
    return success();
}

}  // namespace

bool looksLikeAstra(const std::filesystem::path& path) {
    auto reader = LineReader::open(path);
    for (std::string_view line; reader && reader->lineNumber() < maxProbedLines;) {
        const auto more = reader->next(line);
        if (!more || !*more) return false;
        if (!isRow(line)) continue;
        std::array<std::string_view, columnsOfFile + 1> fields;
        if (splitFields(line, ' ', fields) != columnsOfFile) return false;
        Row row{};
        for (std::size_t i = 0; i < columnsOfFile; ++i) {
            const auto value = parseNumber(fields[i]);
            if (!value) return false;
            row[i] = *value;
        }
        return looksLikeParticle(row);
    }
    return false;
}

Result<std::unique_ptr<ParticleSource>> openAstra(const std::vector<std::filesystem::path>& files,
                                                  double mass, Progress& progress) {
    auto source = std::make_unique<AstraSource>(mass, progress);
    OddSteps odd;
    for (const std::filesystem::path& file : inStepOrder(files)) {
        if (progress.cancelled())
            return Error{ErrorCode::cancelled, "", "cancelled while the steps were listed"};
        MOTE_RETURN_IF_ERROR(odd.add(source->addFile(file)));
    }
    MOTE_RETURN_IF_ERROR(odd.finish(!source->steps().empty(), progress));
    return std::unique_ptr<ParticleSource>(std::move(source));
}

}  // namespace mote::prep
