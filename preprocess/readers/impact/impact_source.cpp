// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/impact/impact_deck.h"
#include "preprocess/readers/impact/number_table.h"
#include "preprocess/readers/particle_reader.h"
#include "preprocess/readers/series_source.h"
#include "protocol/base/error.h"

namespace mote::prep {
namespace {

// Whether a table of numbers can be a particle file of IMPACT-Z: nine columns without names are common, and
// read as the wrong nine they make a beam that never was.

constexpr std::uint64_t rowsToLookAt = 1000;
constexpr std::uint64_t fewRows = 20;  // of which nothing is said
constexpr double greatestPhase = 1e6;  // rad
// Charge states of one particle; a deck's mass and the file's may be rounded.
constexpr double leastChargeState = 0.1, greatestChargeState = 200.0;

// Columns of a file, from 0.
constexpr std::size_t checkedPx = 1, checkedPy = 3, phase = 4, energy = 5, chargeOverMass = 6, number = 8;

using Row = std::array<double, NumberTable::maxColumns>;

/// What a row holds that such a file cannot: the column, from 1, and what should stand there.
struct Fault {
    std::size_t column = 0;
    const char* should = "";
};

std::optional<Fault> faultOf(const Row& row, std::size_t columns, double mass) {
    if (std::abs(row[phase]) > greatestPhase) return Fault{phase, "a phase in rad"};
    if (columns <= number) return std::nullopt;
    const double state = std::abs(row[chargeOverMass] * mass);
    if (!(state >= leastChargeState && state <= greatestChargeState))
        return Fault{chargeOverMass, "the charge over the mass, one or a few over the mass in eV"};
    if (row[number] < 0.0 || row[number] != std::floor(row[number]))
        return Fault{number, "the number of the particle"};
    return std::nullopt;
}

Error refused(const std::string& where, std::string why) {
    return {ErrorCode::unsupported, where,
            "this is no particle file of IMPACT-Z: " + std::move(why) +
                "; say what the columns are with --map (x=1 [mm],px=2 [MeV/c])"};
}

/// Looks at the first rows: numbers of particles are whole, charges over masses those of `mass` (eV/c^2),
/// phases those of a bunch, and most energies carry their transverse momenta, where `gamma` of the reference
/// particle is known (else 0). Leaves `table` closed. Errors: unsupported, corrupt.
Status checkImpactZ(NumberTable& table, double mass, double gamma, Progress& progress) {
    const std::uint64_t rows = std::min(table.rows(), rowsToLookAt);
    if (rows == 0) return success();
    MOTE_RETURN_IF_ERROR(table.seek(0, progress));
    std::uint32_t all = 0;
    for (std::size_t i = 0; i < table.columns(); ++i) all |= 1u << i;
    std::uint64_t impossible = 0;
    Row row{};
    for (std::uint64_t i = 0; i < rows; ++i) {
        MOTE_RETURN_IF_ERROR(table.next(all, row));
        if (const auto fault = faultOf(row, table.columns(), mass)) {
            return refused(table.where() + ", column " + std::to_string(fault->column + 1),
                           "here should stand " + std::string(fault->should));
        }
        const double own = gamma - row[energy];
        const double whole = (own - 1.0) * (own + 1.0);
        if (gamma > 0.0 && !(whole >= row[checkedPx] * row[checkedPx] + row[checkedPy] * row[checkedPy]))
            ++impossible;
    }
    table.close();
    if (rows < fewRows || impossible <= rows / 2) return success();
    return refused(table.where(), "the energies of " + std::to_string(impossible) + " of its first " +
                                      std::to_string(rows) +
                                      " rows are less than their transverse momenta ask for");
}

/// How a row of an IMPACT particle file becomes a particle.
struct ImpactColumns {
    using Row = std::array<double, NumberTable::maxColumns>;

    ImpactDeck::Code code = ImpactDeck::Code::impactZ;
    double mass = 0.0;              ///< eV/c^2
    double angularFrequency = 0.0;  ///< rad/s, of the scaling (IMPACT-Z)
    double gamma = 1.0;             ///< of the reference particle at this step (IMPACT-Z)
    double weight = 1.0;            ///< of every particle, where the file has no column for it
    std::size_t columns = 0;        ///< of the file

    bool hasWeightColumn() const { return columns >= 8; }
    bool hasIdColumn() const { return columns >= 9; }

    /// The columns of the file that a column of the run needs, one bit each.
    std::uint32_t needed(Column column) const;
    /// A column of the run, but id, from a row of the file. Not a number where it has no value: a particle
    /// whose energy does not carry its transverse momentum.
    double value(Column column, const Row& row) const;
};

// Columns of a file, from 0.
constexpr std::size_t xColumn = 0, pxColumn = 1, yColumn = 2, pyColumn = 3, longitudinal = 4,
                      energyColumn = 5, chargeColumn = 7, idColumn = 8;

constexpr std::uint32_t bit(std::size_t column) {
    return 1u << column;
}

/// IMPACT-Z writes -(gamma - gamma of the reference particle).
double longitudinalMomentum(double gamma, double gbx, double gby) {
    return std::sqrt((gamma - 1.0) * (gamma + 1.0) - gbx * gbx - gby * gby);
}

std::uint32_t ImpactColumns::needed(Column column) const {
    const bool z = code == ImpactDeck::Code::impactZ;
    switch (column) {
        case Column::x:
            return bit(xColumn);
        case Column::px:
            return bit(pxColumn);
        case Column::y:
            return bit(yColumn);
        case Column::py:
            return bit(pyColumn);
        case Column::z:
        case Column::t:
            return bit(longitudinal);
        case Column::pz:
            return bit(energyColumn) | (z ? bit(pxColumn) | bit(pyColumn) : 0);
        case Column::weight:
            return hasWeightColumn() ? bit(chargeColumn) : 0;
        case Column::id:
            return hasIdColumn() ? bit(idColumn) : 0;
    }
    return 0;
}

double ImpactColumns::value(Column column, const Row& row) const {
    const bool z = code == ImpactDeck::Code::impactZ;
    const double length = z ? speedOfLight / angularFrequency : 1.0;
    switch (column) {
        case Column::x:
            return row[xColumn] * length;
        case Column::y:
            return row[yColumn] * length;
        case Column::px:
            return row[pxColumn] * mass;
        case Column::py:
            return row[pyColumn] * mass;
        case Column::z: {
            if (!z) return row[longitudinal];
            // A particle that arrives later (a greater phase) lies behind.
            const double beta = std::sqrt((gamma - 1.0) * (gamma + 1.0)) / gamma;
            return -row[longitudinal] * beta * length;
        }
        case Column::t:
            return row[longitudinal] / angularFrequency;
        case Column::pz:
            if (!z) return row[energyColumn] * mass;
            return longitudinalMomentum(gamma - row[energyColumn], row[pxColumn], row[pyColumn]) * mass;
        case Column::weight:
            return hasWeightColumn() ? std::abs(row[chargeColumn]) : weight;
        case Column::id:
            break;
    }
    return 0.0;
}

constexpr std::size_t fewestColumns = 6, columnsOfImpactZ = 9;

class ImpactSource : public SeriesSource {
  public:
    ImpactSource(ImpactDeck::Code code, const proto::ImpactOptions& options, Progress& progress)
        : SeriesSource(code == ImpactDeck::Code::impactZ ? "impactz" : "impactt", progress),
          code_(code),
          options_(options) {}

    /// What all steps share, from the options and from files beside the first one.
    Status readUnits(const std::filesystem::path& beside);

    double mass() const override { return units_.mass; }
    std::string weightUnit() const override { return has(Column::weight) ? "C" : ""; }

  protected:
    Status addFile(const std::filesystem::path& path) override;
    bool hasEverywhere(Column column) const override;
    Status readRows(std::size_t step, const std::vector<Column>& wanted, ParticleChunk& chunk) override;

  private:
    struct Dump {
        NumberTable table;
        ImpactColumns columns;
    };

    bool impactZ() const { return code_ == ImpactDeck::Code::impactZ; }
    Status readDeck(const std::filesystem::path& beside);
    Status setUnits();
    Status readTrack(const std::filesystem::path& beside);
    bool setReference(std::int64_t number, ImpactColumns& columns, SourceStep& step);
    void fillRow(const ImpactColumns& columns, const ImpactColumns::Row& row, std::size_t at,
                 const std::vector<Column>& wanted, ParticleChunk& chunk);

    ImpactDeck::Code code_;
    proto::ImpactOptions options_;
    std::optional<ImpactDeck> deck_;
    std::optional<ReferenceTrack> track_;
    ImpactColumns units_;  // what all steps share
    bool uniformWeight_ = false, notedEnergy_ = false;
    std::vector<Dump> dumps_;
    std::size_t open_ = 0;
};

bool positive(double value) {
    return value > 0.0 && std::isfinite(value);
}

Status ImpactSource::readUnits(const std::filesystem::path& beside) {
    MOTE_RETURN_IF_ERROR(readDeck(beside));
    MOTE_RETURN_IF_ERROR(setUnits());
    return impactZ() ? readTrack(beside) : success();
}

Status ImpactSource::readDeck(const std::filesystem::path& beside) {
    const auto path = ImpactDeck::beside(beside, code_);
    if (!path) return success();
    auto deck = ImpactDeck::read(*path, code_);
    if (!deck) {
        // What the user gives in its place makes a broken deck harmless.
        if (options_.has_mass() && (options_.has_frequency() || !impactZ())) return success();
        return deck.error();
    }
    progress_.note("units and mass are those of " + path->filename().string() + " beside the input");
    deck_ = std::move(*deck);
    return success();
}

Status ImpactSource::setUnits() {
    units_.code = code_;
    const double frequency = options_.has_frequency() ? options_.frequency() : deck_ ? deck_->frequency : 0.0;
    units_.mass = options_.has_mass() ? options_.mass() : deck_ ? deck_->mass : 0.0;
    const double current = options_.has_current() ? options_.current() : deck_ ? deck_->current : 0.0;
    if (impactZ() && !positive(frequency)) {
        return invalid("impact.frequency",
                       "no ImpactZ.in stands beside the input; give the scaling frequency in Hz");
    }
    if (impactZ() && !positive(units_.mass)) {
        return invalid("impact.mass",
                       "no ImpactZ.in stands beside the input; give the particle's mass in eV/c^2");
    }
    if (!positive(units_.mass)) {
        units_.mass = electronMass;
        progress_.note(
            "no ImpactT.in stands beside the input and no mass is given: the particles are taken for "
            "electrons");
    }
    units_.angularFrequency = radiansPerTurn * frequency;
    // The charge of a bunch, shared evenly by its macro-particles.
    if (positive(frequency) && positive(std::abs(current)) && deck_ && deck_->particles >= 1.0) {
        units_.weight = std::abs(current) / frequency / deck_->particles;
        uniformWeight_ = positive(units_.weight);
    }
    if (!uniformWeight_) units_.weight = 1.0;
    return success();
}

Status ImpactSource::readTrack(const std::filesystem::path& beside) {
    if (options_.has_kinetic_energy()) return success();
    const auto path = fileBeside(beside, "fort.18");
    if (!path || !deck_ || deck_->dumps.empty()) return success();
    MOTE_ASSIGN_OR_RETURN(auto track, ReferenceTrack::read(*path));
    progress_.note("the reference particle's energy and time at each step are those of " +
                   path->filename().string() + ", at the place of the step in the deck");
    track_ = std::move(track);
    return success();
}

Status ImpactSource::addFile(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(auto table, NumberTable::open(path, fewestColumns, progress_));
    ImpactColumns columns = units_;
    columns.columns = table.columns();
    SourceStep step = stepOf(path, table.rows());
    if (const auto declared = table.shape().declared; declared && *declared != table.rows()) {
        progress_.note(step.file + " says that it has " + std::to_string(*declared) + " particles and has " +
                       std::to_string(table.rows()));
    }
    const bool known = impactZ() && setReference(step.iteration, columns, step);
    if (!std::isfinite(columns.gamma) || columns.gamma < 1.0) {
        return invalid("impact.kinetic_energy", "needs a number of at least 0");
    }
    if (impactZ()) {
        MOTE_RETURN_IF_ERROR(checkImpactZ(table, columns.mass, known ? columns.gamma : 0.0, progress_));
    }
    steps_.push_back(std::move(step));
    dumps_.push_back({std::move(table), columns});
    return success();
}

/// The reference particle at a dump: a dump does not hold it. False where it is not known.
bool ImpactSource::setReference(std::int64_t number, ImpactColumns& columns, SourceStep& step) {
    if (options_.has_kinetic_energy()) {
        columns.gamma = 1.0 + options_.kinetic_energy() / columns.mass;
        return true;
    }
    const auto place = deck_ ? deck_->dumps.find(number) : std::map<std::int64_t, double>::const_iterator();
    if (track_ && deck_ && place != deck_->dumps.end()) {
        const ReferenceTrack::Point point = track_->at(place->second);
        columns.gamma = point.gamma;
        step.time = point.phase / columns.angularFrequency;
        return true;
    }
    columns.gamma = 1.0 + (deck_ ? deck_->kineticEnergy : 0.0) / columns.mass;
    if (notedEnergy_) return false;
    notedEnergy_ = true;
    progress_.note(
        deck_ ? "the reference particle's energy is not known at " + step.file +
                    " (no fort.18 beside it, or no such file in the deck): that at the start is taken, "
                    "so z and pz are wrong by the energy gained since"
              : "the reference particle's energy is not known: give impact.kinetic_energy, or z and pz are "
                "those of a beam at rest");
    return false;
}

bool ImpactSource::hasEverywhere(Column column) const {
    const auto all = [&](auto condition) {
        return std::all_of(dumps_.begin(), dumps_.end(), [&](const Dump& dump) {
            return dump.table.rows() == 0 || condition(dump.columns);
        });
    };
    if (column == Column::t) return impactZ();
    if (column == Column::weight) {
        return uniformWeight_ || all([](const ImpactColumns& columns) { return columns.hasWeightColumn(); });
    }
    if (column == Column::id) return all([](const ImpactColumns& columns) { return columns.hasIdColumn(); });
    return true;
}

Status ImpactSource::readRows(std::size_t step, const std::vector<Column>& wanted, ParticleChunk& chunk) {
    if (open_ != step) dumps_[open_].table.close();
    open_ = step;
    Dump& dump = dumps_[step];
    MOTE_RETURN_IF_ERROR(dump.table.seek(chunk.begin, progress_));
    std::uint32_t needed = 0;
    for (const Column column : wanted) needed |= dump.columns.needed(column);
    ImpactColumns::Row row{};
    for (std::size_t i = 0; i < chunk.size; ++i) {
        MOTE_RETURN_IF_ERROR(dump.table.next(needed, row));
        fillRow(dump.columns, row, i, wanted, chunk);
    }
    return success();
}

void ImpactSource::fillRow(const ImpactColumns& columns, const ImpactColumns::Row& row, std::size_t at,
                           const std::vector<Column>& wanted, ParticleChunk& chunk) {
    for (const Column column : wanted) {
        if (column != Column::id) {
            chunk[column][at] = columns.value(column, row);
            continue;
        }
        const double id = row[idColumn];
        if (columns.hasIdColumn() && id >= 0.0 && id < 18446744073709551616.0)
            chunk.id[at] = static_cast<std::uint64_t>(id);
    }
}

template <ImpactDeck::Code code>
Result<std::unique_ptr<ParticleSource>> openImpact(const AskedRun& run, Progress& progress) {
    auto source = std::make_unique<ImpactSource>(code, run.job.impact(), progress);
    MOTE_RETURN_IF_ERROR(source->readUnits(run.files.front()));
    return openSeries(std::move(source), inOrder(run.files));
}

/// Whether a deck stands beside the file, and none of the other code.
bool deckSays(const AskedFile& file, ImpactDeck::Code code, ImpactDeck::Code other) {
    return file.shape.columns >= fewestColumns && ImpactDeck::beside(file.path, code) &&
           !ImpactDeck::beside(file.path, other);
}

// A table of numbers without names: what its columns mean the deck beside it says, or the job.

Result<bool> tellsImpactZ(const AskedFile& file) {
    using Code = ImpactDeck::Code;
    if (!file.shape.numbers || deckSays(file, Code::impactT, Code::impactZ)) return false;
    return deckSays(file, Code::impactZ, Code::impactT) ||
           (file.shape.columns == columnsOfImpactZ && file.job.impact().has_frequency());
}

Result<bool> tellsImpactT(const AskedFile& file) {
    using Code = ImpactDeck::Code;
    if (!file.shape.numbers) return false;
    if (deckSays(file, Code::impactT, Code::impactZ)) return true;
    const auto& options = file.job.impact();
    const bool said = ImpactDeck::beside(file.path, Code::impactT).has_value() || options.has_frequency() ||
                      options.has_current();
    // A first line that counts the rows is OPAL's own.
    return file.shape.columns == fewestColumns && (said || (file.job.has_impact() && !file.shape.declared));
}

}  // namespace

extern const ParticleReader impactZReader;
constinit const ParticleReader impactZReader{
    "impactz", "nine columns of numbers, and ImpactZ.in beside it or a frequency", ParticleReader::Kind::rows,
    tellsImpactZ, openImpact<ImpactDeck::Code::impactZ>};
extern const ParticleReader impactTReader;
constinit const ParticleReader impactTReader{"impactt", "six columns of numbers, and ImpactT.in beside it",
                                             ParticleReader::Kind::rows, tellsImpactT,
                                             openImpact<ImpactDeck::Code::impactT>};

}  // namespace mote::prep
