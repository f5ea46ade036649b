// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/impact/number_table.h"
#include "preprocess/readers/known_species.h"
#include "preprocess/readers/particle_reader.h"
#include "preprocess/readers/series_source.h"

namespace mote::prep {
namespace {

using Row = std::array<double, NumberTable::maxColumns>;

// Columns of a file, from 0, and their units: m, eV/c, ns, nC.
constexpr std::size_t xColumn = 0, yColumn = 1, zColumn = 2, pxColumn = 3, pyColumn = 4, pzColumn = 5,
                      clockColumn = 6, chargeColumn = 7, speciesColumn = 8, statusColumn = 9,
                      columnsOfFile = 10;
constexpr double nano = 1e-9;
constexpr double mostSpecies = 14;
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

class AstraSource : public SeriesSource {
  public:
    AstraSource(double mass, Progress& progress) : SeriesSource("astra", progress), mass_(mass) {}

    double mass() const override { return mass_; }
    std::string species() const override { return ofNumber(species_.value_or(0.0)).name; }
    double particleCharge() const override { return ofNumber(species_.value_or(0.0)).charge; }
    std::string weightUnit() const override { return "C"; }

  protected:
    Status addFile(const std::filesystem::path& path) override;
    bool hasEverywhere(Column column) const override { return column != Column::id; }
    Status readRows(std::size_t step, const std::vector<Column>& wanted, ParticleChunk& chunk) override;

  private:
    struct Dump {
        NumberTable table;
        double z = 0, pz = 0, clock = 0;  // of the reference particle, in the file's units
    };

    Status setMass(const Row& reference, const std::string& file);
    static std::uint32_t needed(const std::vector<Column>& wanted);
    static double value(Column column, const Row& row, const Dump& dump, bool reference);

    double mass_;
    std::optional<double> species_;
    std::vector<Dump> dumps_;
    std::size_t open_ = 0;
};

Status AstraSource::addFile(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(auto table, NumberTable::open(path, columnsOfFile, progress_));
    const std::string name = path.filename().string();
    Dump dump{std::move(table)};
    SourceStep step = stepOf(path, dump.table.rows());
    step.iteration = stepNumber(path).value_or(step.iteration);
    if (dump.table.rows() > 0) {
        Row row{};
        MOTE_RETURN_IF_ERROR(dump.table.seek(0, progress_));
        MOTE_RETURN_IF_ERROR(dump.table.next(allBits, row));
        if (!looksLikeParticle(row)) {
            return corrupt(name,
                           "is no ASTRA distribution: columns 9 and 10 of its first row are no species (1 to "
                           "14) and status");
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
        return invalid(file, "has particles of another species than the first file");
    }
    if (!species_ && mass_ <= 0.0) {
        mass_ = ofNumber(species).mass;
        if (mass_ == 0.0) {
            progress_.note("the mass of species " + std::to_string(static_cast<int>(species)) +
                           " stands in ASTRA's input, not in the file: give it (--mass)");
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

Status AstraSource::readRows(std::size_t step, const std::vector<Column>& wanted, ParticleChunk& chunk) {
    if (open_ != step) dumps_[open_].table.close();
    open_ = step;
    Dump& dump = dumps_[step];
    MOTE_RETURN_IF_ERROR(dump.table.seek(chunk.begin, progress_));
    Row row{};
    const std::uint32_t bits = needed(wanted);
    for (std::size_t i = 0; i < chunk.size; ++i) {
        MOTE_RETURN_IF_ERROR(dump.table.next(bits, row));
        chunk.lost[i] = row[statusColumn] < lastWaiting ? 1 : 0;
        for (const Column column : wanted) {
            if (column != Column::id) chunk[column][i] = value(column, row, dump, chunk.begin + i == 0);
        }
    }
    return success();
}

}  // namespace

extern const ParticleReader astraReader;
constinit const ParticleReader astraReader{
    "astra", "ten columns of numbers, of which the last two can be a species and a status",
    ParticleReader::Kind::rows,
    [](const AskedFile& file) -> Result<bool> {
        return file.shape.numbers && !file.shape.declared && file.shape.columns == columnsOfFile &&
               looksLikeParticle(file.shape.first);
    },
    [](const AskedRun& run, Progress& progress) {
        return openSeries(std::make_unique<AstraSource>(run.mass, progress), inOrder(run.files, stepNumber));
    }};

}  // namespace mote::prep
