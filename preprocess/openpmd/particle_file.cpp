// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/openpmd/particle_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "preprocess/openpmd/records.h"
#include "storage/beam/neutral_species.h"

namespace mote::prep {
namespace {

/// Names that the records have which we write; what the source calls so has another.
constexpr std::array ownNames{
    &records::position, &records::positionOffset, &records::momentum, &records::time,   &records::mass,
    &records::charge,   &records::weighting,      &records::weight,   &records::status, &records::identity};
constexpr double kilogramsOfEv = elementaryCharge / (speedOfLight * speedOfLight);  // kg in one eV/c^2

struct Unit {
    std::string_view name;
    double unitSI;
    std::array<double, 7> dimension;
};
constexpr std::array<Unit, 8> units{{{"m", 1.0, {1, 0, 0, 0, 0, 0, 0}},
                                     {"s", 1.0, {0, 0, 1, 0, 0, 0, 0}},
                                     {"eV/c", electronvoltOverC, {1, 1, -1, 0, 0, 0, 0}},
                                     {"eV", elementaryCharge, {2, 1, -2, 0, 0, 0, 0}},
                                     {"C", 1.0, {0, 0, 1, 1, 0, 0, 0}},
                                     {"A", 1.0, {0, 0, 0, 1, 0, 0, 0}},
                                     {"rad", 1.0, {0, 0, 0, 0, 0, 0, 0}},
                                     {"1", 1.0, {0, 0, 0, 0, 0, 0, 0}}}};

constexpr double liveStatus = 1.0, lostStatus = 2.0;  // as openPMD-beamphysics has it

/// A component of a vector record: "position" and "x" of the column "x".
struct Component {
    const RecordKind* record;
    const char* name;
};

Component componentOf(std::string_view column) {
    for (const char* axis : axisNames) {
        if (column == axis) return {&records::position, axis};
        if (column.size() == 2 && column[0] == 'p' && column.substr(1) == axis)
            return {&records::momentum, axis};
    }
    return {nullptr, nullptr};
}

/// A column of `rows` in a vector record, which is made with its first one.
bool addComponent(hid_t species, const Component& component, double unit, std::uint64_t rows) {
    const auto& kind = *component.record;
    const bool there = H5Lexists(species, kind.name, H5P_DEFAULT) > 0;
    const H5Handle record = there ? H5Handle(H5Gopen2(species, kind.name, H5P_DEFAULT), H5Gclose)
                                  : createGroup(species, kind.name);
    if (!record.ok() || (!there && !describeRecord(record.get(), kind))) return false;
    const H5Handle column = createColumn(record.get(), component.name, H5T_IEEE_F64LE, rows);
    return column.ok() && setDouble(column.get(), "unitSI", unit);
}

/// A name that HDF5 takes for one link, the source's may hold "/", and that is free.
std::string linkName(hid_t species, const std::string& column) {
    std::string name = column == "." ? "_" : column;
    std::ranges::replace(name, '/', '_');
    const auto taken = [&] {
        const bool own = std::ranges::any_of(ownNames, [&](const auto* kind) { return name == kind->name; });
        return own || H5Lexists(species, name.c_str(), H5P_DEFAULT) > 0;
    };
    while (taken()) name += "_";
    return name;
}

bool addOther(hid_t species, const FileColumn& column, const std::string& name, std::uint64_t rows) {
    const auto* const unit = std::ranges::find(units, column.unit, &Unit::name);
    const bool known = unit != units.end();
    const H5Handle record = createColumn(species, name.c_str(), H5T_IEEE_F64LE, rows);
    const RecordKind kind{name.c_str(), known ? unit->dimension : std::array<double, 7>{}, 0, 0.0};
    return record.ok() && describeRecord(record.get(), kind) &&
           setDouble(record.get(), "unitSI", known ? unit->unitSI : 1.0) &&
           (known || setText(record.get(), "unit", column.unit));
}

bool describeFile(hid_t file) {
    return setText(file, "openPMD", "1.1.0") &&
           setText(file, "openPMDextension", "BeamPhysics;SpeciesType") &&
           setText(file, "basePath", "/data/%T/") && setText(file, "particlesPath", "particles/") &&
           setText(file, "iterationEncoding", "groupBased") &&
           setText(file, "iterationFormat", "/data/%T/") && setText(file, "software", "mote-prep export") &&
           setText(file, "softwareVersion", MOTE_VERSION);
}

}  // namespace

ParticleFile::ParticleFile(const std::string& path)
    : name_(path), errors_(std::make_unique<H5Errors>()), file_(createFile(path)) {}

ParticleFile::~ParticleFile() {
    if (file_.ok()) forgetUnwritten(file_.get());
}

Result<ParticleFile> ParticleFile::create(const std::filesystem::path& path) {
    ParticleFile file(path.string());
    if (!file.file_.ok() || !describeFile(file.file_.get())) return file.errors_->failure(file.name_);
    return file;
}

bool ParticleFile::describeSpecies(hid_t species, const FileStep& step) const {
    bool described = setText(species, "speciesType", step.species.empty() ? "other" : step.species) &&
                     setUnsigned64(species, "numParticles", step.rows) &&
                     setDouble(species, "chargeUnitSI", 1.0);
    if (described && step.lost) {
        const double status = *step.lost ? lostStatus : liveStatus;
        described = addConstantScalar(species, records::status, status, step.rows);
    }
    if (described && (step.charge != 0.0 || storage::isNeutral(step.species))) {
        described = addConstantScalar(species, records::charge, step.charge, step.rows);
    }
    if (!described || step.mass == 0.0) return described;
    return addConstantScalar(species, records::mass, step.mass * kilogramsOfEv, step.rows);
}

bool ParticleFile::addWeights(hid_t species, const FileStep& step) {
    auto& targets = targets_.back();
    const double one = std::abs(step.charge);
    const bool charges = step.weightUnit == "C";
    const auto add = [&](const RecordKind& kind, double factor) {
        targets.push_back({kind.name, factor});
        return addScalar(species, kind, H5T_IEEE_F64LE, 1.0, step.rows);
    };
    bool ok = true;
    if (!charges || one > 0.0) ok = add(records::weighting, charges ? 1.0 / one : 1.0);
    if (step.weightUnit.empty()) return ok;
    // A particle whose charge nobody says counts an elementary one, as in statistics.
    weightUnit_ = charges ? 1.0 : one > 0.0 ? one : elementaryCharge;
    charge_ = 0.0;
    weightColumn_ = targets_.size() - 1;
    // Neutral ones have no charge to be told of.
    if (!charges && storage::isNeutral(step.species)) {
        weightUnit_ = 0.0;
        return ok;
    }
    return ok && add(records::weight, weightUnit_);
}

bool ParticleFile::addColumn(hid_t species, const FileStep& step, const FileColumn& column) {
    auto& targets = targets_.emplace_back();
    const auto scalar = [&](const RecordKind& kind) {
        targets.push_back({kind.name});
        return addScalar(species, kind, H5T_IEEE_F64LE, 1.0, step.rows);
    };
    if (const auto component = componentOf(column.name); component.record != nullptr) {
        targets.push_back({fmt::format("{}/{}", component.record->name, component.name)});
        const bool momentum = component.record == &records::momentum;
        return addComponent(species, component, momentum ? electronvoltOverC : 1.0, step.rows);
    }
    if (column.name == "t") return scalar(records::time);
    if (column.name == "weight") return addWeights(species, step);
    if (column.name == "lost" && !step.lost) {
        statusColumn_ = targets_.size() - 1;
        return scalar(records::status);
    }
    const auto name = linkName(species, column.name);
    targets.push_back({name});
    return addOther(species, column, name, step.rows);
}

bool ParticleFile::endStep() {
    if (!charge_) return true;
    const H5Handle species(H5Gopen2(file_.get(), species_.c_str(), H5P_DEFAULT), H5Gclose);
    return species.ok() && setDouble(species.get(), "totalCharge", *std::exchange(charge_, std::nullopt));
}

Status ParticleFile::begin(const FileStep& step) {
    if (!endStep()) return errors_->failure(name_);
    const auto iteration = fmt::format("/data/{}", step.iteration);
    species_ = iteration + "/particles/beam";
    targets_.clear();
    statusColumn_.reset();
    const H5Handle group = createGroup(file_.get(), iteration);
    bool ok = group.ok() && setDouble(group.get(), "time", step.time) && setDouble(group.get(), "dt", 0.0) &&
              setDouble(group.get(), "timeUnitSI", 1.0);
    const H5Handle species = ok ? createGroup(file_.get(), species_) : H5Handle();
    ok = ok && species.ok() && describeSpecies(species.get(), step);
    bool timed = false;
    for (const auto& column : step.columns) {
        timed = timed || column.name == "t";
        ok = ok && addColumn(species.get(), step, column);
    }
    if (ok && !timed) ok = addConstantScalar(species.get(), records::time, step.time, step.rows);
    if (ok && step.ids) ok = addScalar(species.get(), records::identity, H5T_STD_U64LE, 1.0, step.rows);
    return ok ? success() : Status(errors_->failure(name_));
}

Status ParticleFile::write(std::uint64_t first, std::size_t rows,
                           std::span<const std::vector<double>> columns,
                           const std::vector<std::uint64_t>& ids) {
    bool ok = true;
    std::vector<double> scaled;
    for (std::size_t i = 0; i < targets_.size(); ++i) {
        for (const auto& target : targets_[i]) {
            const auto* values = &columns[i];
            if (target.factor != 1.0 || i == statusColumn_) {
                scaled = columns[i];
                for (double& value : scaled)
                    value =
                        i == statusColumn_ ? (value != 0.0 ? lostStatus : liveStatus) : value * target.factor;
                values = &scaled;
            }
            ok = ok && writeColumn(file_.get(), species_ + "/" + target.path, H5T_NATIVE_DOUBLE, first, rows,
                                   values->data());
        }
    }
    if (charge_) {
        for (std::size_t row = 0; row < rows; ++row) *charge_ += columns[weightColumn_][row] * weightUnit_;
    }
    if (ok && !ids.empty())
        ok = writeColumn(file_.get(), species_ + "/id", H5T_NATIVE_UINT64, first, rows, ids.data());
    return ok ? success() : Status(errors_->failure(name_));
}

Status ParticleFile::close() {
    if (!endStep() || H5Fflush(file_.get(), H5F_SCOPE_GLOBAL) < 0) return errors_->failure(name_);
    file_ = {};
    return success();
}

}  // namespace mote::prep
