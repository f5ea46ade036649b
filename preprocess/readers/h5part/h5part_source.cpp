// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/hdf5/h5_attribute.h"
#include "preprocess/readers/hdf5/h5_column.h"
#include "preprocess/readers/known_species.h"
#include "preprocess/readers/openpmd/layout.h"
#include "preprocess/readers/particle_reader.h"
#include "preprocess/readers/series_source.h"

namespace mote::prep {
namespace {

/// The columns of one step of an H5Part file. Owned by the source; one thread at a time.
///
/// H5Part itself names no units. OPAL writes them as attributes of the file (xUnit "m", pxUnit "#beta#gamma")
/// and of the step (MASS in GeV, TIME in s); where there are none, m, eV/c, s and C are taken.
class H5PartStep {
  public:
    /// The group at `path`; `mass` in eV/c^2, 0: as the file says. Errors: corrupt (columns of different
    /// lengths), unsupported, invalidArgument (units that need a mass), notFound (no column of a particle).
    static Result<H5PartStep> open(const H5File& file, const std::string& path, double mass);

    std::uint64_t rows() const { return rows_; }
    bool has(Column column) const { return columns_[static_cast<std::size_t>(column)].has_value(); }
    double mass() const { return mass_; }  ///< eV/c^2; 0: unknown
    double time() const { return time_; }  ///< s
    bool unitsGiven() const { return unitsGiven_; }
    /// As ParticleSource::weightUnit.
    std::string weightUnit() const { return coulomb_ ? "C" : ""; }
    /// Of the first particle's charge; 0 where there is none.
    double chargeSign() const { return chargeSign_; }

    /// The group's other columns of numbers, under their names, in the units that attributes say.
    struct Record {
        SourceRecord told;
        H5Column column;
    };
    const std::vector<Record>& records() const { return records_; }

    /// As SeriesSource::readRows; of records nothing.
    Status read(const std::vector<Column>& wanted, ParticleChunk& chunk) const;
    /// One of the records by its name. Error: corrupt.
    Status readRecord(const std::string& name, const ParticleChunk& chunk, std::vector<double>& values) const;

  private:
    Status readMeaning(const H5File& file, const H5Object& step);
    Status openColumn(const H5File& file, const H5Object& step, std::size_t column, const char* name);
    Result<double> unitOf(const H5File& file, const H5Object& step, std::size_t column, const char* name);
    Status openRecords(const H5File& file, const H5Object& step);

    std::uint64_t rows_ = 0;
    double mass_ = 0.0, time_ = 0.0;
    double chargeSign_ = 0.0;
    bool unitsGiven_ = false, coulomb_ = false;
    std::array<std::optional<H5Column>, columnCount> columns_;
    std::array<double, columnCount> factors_{};
    std::vector<Record> records_;
};

constexpr double gigaelectronvolt = 1e9;

struct H5PartName {
    Column column;
    const char* name;
};

// The first name that a step has is taken.
constexpr H5PartName columnNames[] = {{Column::x, "x"},           {Column::y, "y"},    {Column::z, "z"},
                                      {Column::t, "t"},           {Column::t, "time"}, {Column::px, "px"},
                                      {Column::py, "py"},         {Column::pz, "pz"},  {Column::weight, "q"},
                                      {Column::weight, "weight"}, {Column::id, "id"}};

Result<H5PartStep> H5PartStep::open(const H5File& file, const std::string& path, double mass) {
    MOTE_ASSIGN_OR_RETURN(const auto group, file.require(file.root(), path));
    H5PartStep step;
    step.mass_ = mass;
    MOTE_RETURN_IF_ERROR(step.readMeaning(file, group));
    for (const H5PartName& name : columnNames) {
        const auto column = static_cast<std::size_t>(name.column);
        if (!step.columns_[column]) MOTE_RETURN_IF_ERROR(step.openColumn(file, group, column, name.name));
    }
    bool first = true;
    for (const auto& column : step.columns_) {
        if (!column) continue;
        if (first) step.rows_ = column->rows();
        first = false;
        if (column->rows() != step.rows_) {
            return corrupt(column->object().where, "has " + std::to_string(column->rows()) +
                                                       " values where other columns have " +
                                                       std::to_string(step.rows_));
        }
    }
    if (first) return notFound(group.where, "holds none of the columns x, y, z, px, py, pz");
    MOTE_RETURN_IF_ERROR(step.openRecords(file, group));
    return step;
}

/// What is no column of as many numbers is passed by, as nobody asked for it.
Status H5PartStep::openRecords(const H5File& file, const H5Object& step) {
    constexpr std::size_t mostLookedAt = 1024;
    MOTE_ASSIGN_OR_RETURN(const auto children, file.children(step));
    for (const auto& name : std::span(children).first(std::min(children.size(), mostLookedAt))) {
        auto told = recordOf(name);
        auto found = told ? file.find(step, name) : Result<std::optional<H5Object>>(std::nullopt);
        if (!found.ok() || !found->has_value() || (*found)->group) continue;
        auto opened = H5Column::open(file, std::move(**found));
        if (!opened.ok() || opened->rows() != rows_) continue;
        for (const H5Object* object : {&step, &file.root()}) {
            const auto unit = textAttribute(*object, (name + "Unit").c_str());
            if (!unit.ok() || !*unit || (*unit)->empty()) continue;
            told->unit = **unit;
            break;
        }
        records_.push_back({*std::move(told), *std::move(opened)});
    }
    return success();
}

Status H5PartStep::readMeaning(const H5File& file, const H5Object& step) {
    for (const H5Object* object : {&step, &file.root()}) {
        MOTE_ASSIGN_OR_RETURN(const auto mass, numberAttribute(*object, "MASS"));
        if (mass_ == 0.0 && mass && *mass > 0.0 && std::isfinite(*mass)) mass_ = *mass * gigaelectronvolt;
    }
    for (const char* name : {"TIME", "Time", "time"}) {
        MOTE_ASSIGN_OR_RETURN(const auto time, numberAttribute(step, name));
        if (!time || !std::isfinite(*time)) continue;
        time_ = *time;
        break;
    }
    return success();
}

Status H5PartStep::openColumn(const H5File& file, const H5Object& step, std::size_t column,
                              const char* name) {
    MOTE_ASSIGN_OR_RETURN(auto found, file.find(step, name));
    if (!found.has_value() || found->group) return success();
    MOTE_ASSIGN_OR_RETURN(auto opened, H5Column::open(file, std::move(*found)));
    const bool weights = static_cast<Column>(column) == Column::weight;
    coulomb_ = coulomb_ || (weights && std::string_view(name) == "q");  // unless its unit says otherwise
    MOTE_ASSIGN_OR_RETURN(const auto factor, unitOf(file, step, column, name));
    if (weights && opened.rows() > 0) {
        double first = 0.0;
        MOTE_RETURN_IF_ERROR(opened.read(0, 1, &first));
        chargeSign_ = first > 0.0 ? 1.0 : first < 0.0 ? -1.0 : 0.0;
    }
    columns_[column] = std::move(opened);
    factors_[column] = factor;
    return success();
}

/// The unit that an attribute of the step or of the file gives to a column.
Result<double> H5PartStep::unitOf(const H5File& file, const H5Object& step, std::size_t column,
                                  const char* name) {
    const std::string attribute = std::string(name) + "Unit";
    for (const H5Object* object : {&step, &file.root()}) {
        MOTE_ASSIGN_OR_RETURN(const auto unit, textAttribute(*object, attribute.c_str()));
        if (!unit || unit->empty()) continue;
        unitsGiven_ = true;
        if (static_cast<Column>(column) == Column::id) return 1.0;
        MOTE_ASSIGN_OR_RETURN(const auto meaning, fieldMeaning(std::string(name) + " [" + *unit + "]", mass_,
                                                               object->where + "@" + attribute));
        if (meaning && meaning->column == Column::weight) coulomb_ = meaning->coulomb;
        return meaning ? meaning->factor : 1.0;
    }
    return 1.0;
}

Status H5PartStep::read(const std::vector<Column>& wanted, ParticleChunk& chunk) const {
    for (const Column column : wanted) {
        if (isRecord(column)) continue;
        const auto& source = columns_[static_cast<std::size_t>(column)];
        if (!source) continue;
        if (column == Column::id) {
            MOTE_RETURN_IF_ERROR(source->read(chunk.begin, chunk.size, chunk.id.data()));
            continue;
        }
        MOTE_RETURN_IF_ERROR(source->read(chunk.begin, chunk.size, chunk[column].data()));
        const double factor = factors_[static_cast<std::size_t>(column)];
        for (double& value : chunk[column])
            value = column == Column::weight ? std::abs(value * factor) : value * factor;
    }
    return success();
}

Status H5PartStep::readRecord(const std::string& name, const ParticleChunk& chunk,
                              std::vector<double>& values) const {
    for (const Record& record : records_) {
        if (record.told.name == name) return record.column.read(chunk.begin, chunk.size, values.data());
    }
    return corrupt(name, "has changed since it was opened");
}

constexpr std::string_view stepPattern = "Step#%T";

struct H5PartPlace {
    std::filesystem::path file;
    std::string group;
};

class H5PartSource : public SeriesSource {
  public:
    H5PartSource(double mass, Progress& progress) : SeriesSource("h5part", progress), wantedMass_(mass) {}

    double mass() const override { return mass_; }
    std::string species() const override { return species_; }
    double particleCharge() const override { return particleCharge_; }
    std::string weightUnit() const override { return weightUnit_; }

  protected:
    Status addFile(const std::filesystem::path& path) override;
    Status finish() override;
    bool hasEverywhere(Column column) const override { return everywhere_[static_cast<std::size_t>(column)]; }
    std::vector<SourceRecord> recordsEverywhere() const override { return records_; }
    Status readRows(std::size_t step, const std::vector<Column>& wanted, ParticleChunk& chunk) override;

  private:
    Status addStep(const H5File& file, const std::filesystem::path& path, const std::string& group,
                   std::int64_t number);

    void findSpecies(double chargeSign);

    double wantedMass_, mass_ = 0.0, particleCharge_ = 0.0;
    std::string species_, weightUnit_;
    bool anyParticles_ = false, unitsGiven_ = true;
    bool everywhere_[columnCount] = {};
    std::vector<SourceRecord> records_;  ///< of all steps with particles
    std::vector<H5PartPlace> places_;
    std::size_t openStep_ = static_cast<std::size_t>(-1);
    std::optional<H5PartStep> open_;
};

Status H5PartSource::addFile(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(const auto file, H5File::open(path));
    MOTE_ASSIGN_OR_RETURN(const auto names, file.children(file.root()));
    bool any = false;
    for (const std::string& name : names) {
        const auto number = matchIteration(stepPattern, name);
        if (!number) continue;
        if (progress_.cancelled()) return wasCancelled("cancelled while the steps were listed");
        MOTE_RETURN_IF_ERROR(leaveOut(addStep(file, path, "/" + name, *number)));
        any = true;
    }
    if (any) return success();
    return notFound(file.name(), "has no group Step#0, Step#1, ...");
}

Status H5PartSource::addStep(const H5File& file, const std::filesystem::path& path, const std::string& group,
                             std::int64_t number) {
    MOTE_ASSIGN_OR_RETURN(const auto step, H5PartStep::open(file, group, wantedMass_));
    steps_.push_back({file.name(), number, step.time(), step.rows()});
    places_.push_back({path, group});
    if (mass_ == 0.0) mass_ = step.mass();
    unitsGiven_ = unitsGiven_ && step.unitsGiven();
    if (step.rows() == 0 && anyParticles_) return success();
    weightUnit_ = anyParticles_ && weightUnit_ != step.weightUnit() ? "" : step.weightUnit();
    if (particleCharge_ == 0.0 && step.weightUnit() == "C") findSpecies(step.chargeSign());
    for (std::size_t i = 0; i < columnCount; ++i) {
        const bool here = step.has(static_cast<Column>(i));
        everywhere_[i] = anyParticles_ ? everywhere_[i] && here : here;
    }
    const auto has = [&](const SourceRecord& record) {
        return std::ranges::any_of(step.records(),
                                   [&](const auto& own) { return own.told.name == record.name; });
    };
    if (!anyParticles_) records_.clear();
    for (const auto& own : step.records()) {
        if (!anyParticles_) records_.push_back(own.told);
    }
    std::erase_if(records_, std::not_fn(has));
    anyParticles_ = anyParticles_ || step.rows() > 0;
    return success();
}

/// The files name none; the sign of the charges beside the mass tells those with one elementary charge.
void H5PartSource::findSpecies(double chargeSign) {
    const auto found = chargeSign != 0.0 ? speciesOf(mass_, chargeSign * elementaryCharge) : std::nullopt;
    if (!found) return;
    species_ = found->name;
    particleCharge_ = chargeSign * elementaryCharge;
}

Status H5PartSource::finish() {
    sortByIteration(places_);
    if (!species_.empty()) {
        progress_.note("the species is " + species_ + ", after the mass and the sign of the charges");
    }
    if (!unitsGiven_) progress_.note("the H5Part file names no units: m, eV/c, s and C are taken");
    return success();
}

Status H5PartSource::readRows(std::size_t step, const std::vector<Column>& wanted, ParticleChunk& chunk) {
    if (openStep_ != step) {
        openStep_ = static_cast<std::size_t>(-1);
        open_.reset();
        MOTE_ASSIGN_OR_RETURN(const auto file, H5File::open(places_[step].file));
        MOTE_ASSIGN_OR_RETURN(auto opened, H5PartStep::open(file, places_[step].group, wantedMass_));
        if (opened.rows() != steps_[step].particles) {
            return corrupt(steps_[step].file, "has changed since it was opened");
        }
        open_ = std::move(opened);
        openStep_ = step;
    }
    for (const Column column : wanted) {
        if (isRecord(column))
            MOTE_RETURN_IF_ERROR(open_->readRecord(recordName(column), chunk, chunk[column]));
    }
    return open_->read(wanted, chunk);
}

}  // namespace

extern const ParticleReader h5partReader;
constinit const ParticleReader h5partReader{
    "h5part", "HDF5 with groups Step#N", ParticleReader::Kind::hdf5,
    [](const AskedFile& file) -> Result<bool> {
        const auto names = file.hdf5->children(file.hdf5->root());
        return names && std::any_of(names->begin(), names->end(), [](const std::string& name) {
                   return matchIteration(stepPattern, name).has_value();
               });
    },
    [](const AskedRun& run, Progress& progress) {
        return openSeries(std::make_unique<H5PartSource>(run.mass, progress), run.files);
    }};

}  // namespace mote::prep
