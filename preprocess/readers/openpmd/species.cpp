// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/openpmd/species.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <string_view>
#include <utility>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/hdf5/h5_attribute.h"
#include "preprocess/readers/known_species.h"

namespace mote::prep {
namespace {

constexpr const char* axisNames[3] = {"x", "y", "z"};

constexpr double sameInSingle = 1e-5;  // macro-particles store mass, charge and weighting in single precision
constexpr double sameMass = 1e-6;      // as who types it means the same
constexpr std::uint64_t rowsForTime = 1u << 16;
constexpr std::size_t rowsTogether = 1u << 13;  // whose values fit a core's cache

constexpr std::size_t mostLookedAt = 1024;  // of a group's members

constexpr std::array<std::string_view, 15> known{"particlePatches",
                                                 "position",
                                                 "positionOffset",
                                                 "momentum",
                                                 "momentumOffset",
                                                 "time",
                                                 "timeOffset",
                                                 "totalMomentum",
                                                 "weight",
                                                 "weighting",
                                                 "charge",
                                                 "totalMomentumOffset",
                                                 "mass",
                                                 "particleStatus",
                                                 "id"};

/// Of powers of m, kg, s, A, K, mol and cd: "m", "kg m^2 s^-1", "1".
std::string unitOfPowers(const std::optional<std::vector<double>>& powers) {
    static constexpr std::array<std::string_view, 7> units{"m", "kg", "s", "A", "K", "mol", "cd"};
    std::string text;
    for (std::size_t i = 0; powers && i < std::min(powers->size(), units.size()); ++i) {
        const double power = (*powers)[i];
        if (power == 0.0) continue;
        text += fmt::format("{}{}", text.empty() ? "" : " ", units[i]);
        if (power != 1.0) text += fmt::format("^{:g}", power);
    }
    return text.empty() ? "1" : text;
}

// Where every component is a constant, nothing in the file's size bears out the number of particles.
constexpr std::uint64_t maxConstantRows = 1ull << 22;

}  // namespace

Result<OpenpmdSpecies> OpenpmdSpecies::open(const H5File& file, const std::string& path,
                                            const std::string& iterationPath, double mass) {
    MOTE_ASSIGN_OR_RETURN(auto group, file.require(file.root(), path));
    MOTE_ASSIGN_OR_RETURN(auto iteration, file.require(file.root(), iterationPath));
    OpenpmdSpecies species;
    MOTE_RETURN_IF_ERROR(species.openRecords(file, group));
    MOTE_RETURN_IF_ERROR(species.checkRows());
    MOTE_RETURN_IF_ERROR(species.openOthers(file, group));
    MOTE_RETURN_IF_ERROR(species.checkMomentumUnits());
    MOTE_RETURN_IF_ERROR(species.findSpecies(group, iteration));
    MOTE_RETURN_IF_ERROR(species.takeMass(mass));
    MOTE_RETURN_IF_ERROR(species.findTime(iteration));
    species.readsAtOnce_ = species.findWhetherAtOnce();
    return species;
}

Status OpenpmdSpecies::openQuantity(const H5File& file, const H5Object& group, Quantity& quantity,
                                    const char* record, const char* offset, const char* component) {
    const std::string name = *component == '\0' ? record : std::string(record) + "/" + component;
    auto value = OpenpmdComponent::open(file, group, record, component);
    if (!value) return drop(name, value.error());
    if (!value->has_value()) return success();
    auto added = OpenpmdComponent::open(file, group, offset, component);
    // An offset that is there and holds nothing adds nothing; one that cannot be read would be missed.
    if (!added && added.error().code == ErrorCode::notFound) {
        notes_.push_back("'" + std::string(offset) + "' of '" + name + "' is empty and is taken for 0");
        added = std::optional<OpenpmdComponent>();
    }
    if (!added) return drop(name, added.error());
    quantity = {name, std::move(*value), std::move(*added)};
    return success();
}

Status OpenpmdSpecies::openRecords(const H5File& file, const H5Object& group) {
    for (std::size_t i = 0; i < 3; ++i) {
        MOTE_RETURN_IF_ERROR(
            openQuantity(file, group, position_[i], "position", "positionOffset", axisNames[i]));
        MOTE_RETURN_IF_ERROR(
            openQuantity(file, group, momentum_[i], "momentum", "momentumOffset", axisNames[i]));
    }
    MOTE_RETURN_IF_ERROR(openQuantity(file, group, positionT_, "position", "positionOffset", "t"));
    MOTE_RETURN_IF_ERROR(openQuantity(file, group, momentumT_, "momentum", "momentumOffset", "t"));
    MOTE_RETURN_IF_ERROR(openQuantity(file, group, timeRecord_, "time", "timeOffset", ""));
    MOTE_RETURN_IF_ERROR(openQuantity(file, group, total_, "totalMomentum", "totalMomentumOffset", ""));
    struct Scalar {
        const char* record;
        std::optional<OpenpmdComponent>& component;
    };
    for (const Scalar& scalar :
         {Scalar{"weighting", weighting_}, Scalar{"weight", charge_}, Scalar{"particleStatus", status_},
          Scalar{"id", id_}, Scalar{"mass", massRecord_}, Scalar{"charge", chargeRecord_}}) {
        auto component = OpenpmdComponent::open(file, group, scalar.record, "");
        if (!component) {
            MOTE_RETURN_IF_ERROR(drop(scalar.record, component.error()));
        } else {
            scalar.component = std::move(*component);
        }
    }
    if (positionT_.value && !position_[2].value) {
        MOTE_ASSIGN_OR_RETURN(auto reference, ReferenceParticle::open(group));
        if (!reference.has_value()) {
            return notFound(
                group.where + "@gamma_ref",
                "is missing: position has t in place of z, which is read relative to a reference particle");
        }
        reference_ = reference;
        if (!reference_->known()) {
            notes_.push_back(
                "the reference particle has no gamma (as in ImpactX' file of lost particles): z and momenta "
                "are missing");
        }
    }
    return success();
}

Status OpenpmdSpecies::checkMomentumUnits() const {
    if (reference_) return success();
    for (const Quantity& quantity : momentum_) {
        if (!quantity.value || !quantity.value->unitDimension()) continue;
        const auto& powers = *quantity.value->unitDimension();
        if (powers.size() < 3 || (powers[0] == 1.0 && powers[1] == 1.0 && powers[2] == -1.0)) continue;
        return unsupported(quantity.value->where() + "@unitDimension",
                           "is not that of a momentum (1, 1, -1)");
    }
    return success();
}

bool OpenpmdSpecies::has(Column column) const {
    const auto axis = static_cast<std::size_t>(column);
    switch (column) {
        case Column::x:
        case Column::y:
            return position_[axis].value.has_value();
        case Column::z:
            return reference_ ? reference_->known() : position_[2].value.has_value();
        case Column::t:
            return reference_ || timeRecord_.value;
        case Column::px:
        case Column::py:
            return momentum_[axis - 4].value && (!reference_ || (reference_->known() && mass_ > 0.0));
        case Column::pz:
            if (reference_)
                return reference_->known() && momentumT_.value && momentum_[0].value && momentum_[1].value &&
                       mass_ > 0.0;
            return momentum_[2].value || (total_.value && momentum_[0].value && momentum_[1].value);
        case Column::weight:
            return weighting_ || charge_;
        case Column::id:
            return id_.has_value();
    }
    return false;
}

Status OpenpmdSpecies::read(const std::vector<Column>& wanted, const std::vector<SourceRecord>& names,
                            ParticleChunk& chunk) const {
    // Whoever reads at once pays little for a call: what is made of values finds them in the core's cache.
    const std::size_t together = readsAtOnce_ ? rowsTogether : chunk.size;
    const auto inParts = [&](const auto& readPart) -> Status {
        for (std::size_t at = 0; at < chunk.size; at += together)
            MOTE_RETURN_IF_ERROR(readPart(chunk.begin + at, at, std::min(together, chunk.size - at)));
        return success();
    };
    for (const Column column : wanted) {
        if (column == Column::id) {
            if (id_) MOTE_RETURN_IF_ERROR(id_->readIntegers(chunk.begin, std::span(chunk.id)));
            continue;
        }
        const std::span all(chunk[column]);
        MOTE_RETURN_IF_ERROR(inParts([&](std::uint64_t begin, std::size_t at, std::size_t size) {
            const auto values = all.subspan(at, size);
            if (!isRecord(column)) return readColumn(column, begin, values);
            return readRecord(names[static_cast<std::size_t>(column) - columnCount].name, begin, values);
        }));
    }
    if (!status_) return success();
    return inParts([&](std::uint64_t begin, std::size_t at, std::size_t size) {
        return readLost(begin, std::span(chunk.lost).subspan(at, size));
    });
}

Status OpenpmdSpecies::readColumn(Column column, std::uint64_t begin, Values values) const {
    if (column == Column::weight) return readWeight(begin, values);
    if (broken(column)) {
        std::fill(values.begin(), values.end(), std::numeric_limits<double>::quiet_NaN());
        return success();
    }
    if (!has(column)) return corrupt("", "has changed since it was opened");
    if (reference_) return readReferenceColumn(column, begin, values);
    const auto axis = static_cast<std::size_t>(column);
    if (column == Column::t) return readQuantity(timeRecord_, begin, values);
    if (axis < 3) return readQuantity(position_[axis], begin, values);
    if (column == Column::pz && !momentum_[2].value) return readLongitudinalFromTotal(begin, values);
    return readMomentum(momentum_[axis - 4], begin, values);
}

Status OpenpmdSpecies::readRecord(const std::string& name, std::uint64_t begin, Values values) const {
    const auto found = std::ranges::find(recordNames_, name, &SourceRecord::name);
    if (found == recordNames_.end()) return corrupt("", "has changed since it was opened");
    const auto& record = records_[static_cast<std::size_t>(found - recordNames_.begin())];
    MOTE_RETURN_IF_ERROR(record.read(begin, values));
    const double power = record.weightingPower();
    if (power == 0.0 || !weighting_) return success();
    return divideByWeighting(power, begin, values);
}

Status OpenpmdSpecies::divideByWeighting(double power, std::uint64_t begin, Values values) const {
    std::vector<double> weights(values.size());
    MOTE_RETURN_IF_ERROR(weighting_->read(begin, weights));
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] /= power == 1.0 ? weights[i] : std::pow(weights[i], power);
    return success();
}

Status OpenpmdSpecies::add(const OpenpmdComponent& offset, std::uint64_t begin, Values values) {
    if (const auto same = offset.constantValue()) {
        for (double& value : values) value += *same;
        return success();
    }
    std::vector<double> added(values.size());
    MOTE_RETURN_IF_ERROR(offset.read(begin, added));
    for (std::size_t i = 0; i < values.size(); ++i) values[i] += added[i];
    return success();
}

Status OpenpmdSpecies::readQuantity(const Quantity& quantity, std::uint64_t begin, Values values) const {
    MOTE_RETURN_IF_ERROR(quantity.value->read(begin, values));
    return quantity.offset ? add(*quantity.offset, begin, values) : success();
}

Status OpenpmdSpecies::readMomentum(const Quantity& quantity, std::uint64_t begin, Values values) const {
    MOTE_RETURN_IF_ERROR(readQuantity(quantity, begin, values));
    const double power = quantity.value->weightingPower();
    if (power != 0.0) {
        if (!weighting_)
            return notFound(quantity.value->where(), "is of macro-particles, but 'weighting' is missing");
        MOTE_RETURN_IF_ERROR(divideByWeighting(power, begin, values));
    }
    for (double& value : values) value *= momentumInEv;
    return success();
}

Status OpenpmdSpecies::readLongitudinalFromTotal(std::uint64_t begin, Values values) const {
    MOTE_RETURN_IF_ERROR(readMomentum(total_, begin, values));
    for (double& value : values) value *= value;
    std::vector<double> transverse(values.size());
    for (std::size_t axis = 0; axis < 2; ++axis) {
        MOTE_RETURN_IF_ERROR(readMomentum(momentum_[axis], begin, transverse));
        for (std::size_t i = 0; i < values.size(); ++i) values[i] -= transverse[i] * transverse[i];
    }
    for (double& value : values) value = std::sqrt(value);
    return success();
}

Status OpenpmdSpecies::readReferenceColumn(Column column, std::uint64_t begin, Values values) const {
    const ReferenceParticle& reference = *reference_;
    const auto axis = static_cast<std::size_t>(column);
    if (axis < 2) return position_[axis].value->read(begin, values);
    if (column == Column::z || column == Column::t) {
        MOTE_RETURN_IF_ERROR(positionT_.value->read(begin, values));
        const double factor = column == Column::z ? -reference.beta() : 1.0 / speedOfLight;
        for (double& value : values) value *= factor;
        return success();
    }
    const double unit = reference.betaGamma * mass_;
    if (column != Column::pz) {
        MOTE_RETURN_IF_ERROR(momentum_[axis - 4].value->read(begin, values));
        for (double& value : values) value *= unit;
        return success();
    }
    MOTE_RETURN_IF_ERROR(momentumT_.value->read(begin, values));
    for (double& value : values) {
        const double gamma = reference.gammaOf(value);
        value = (gamma - 1.0) * (gamma + 1.0);
    }
    std::vector<double> momentum(values.size());
    for (std::size_t i = 0; i < 2; ++i) {
        MOTE_RETURN_IF_ERROR(momentum_[i].value->read(begin, momentum));
        for (std::size_t row = 0; row < values.size(); ++row) {
            const double transverse = momentum[row] * reference.betaGamma;
            values[row] -= transverse * transverse;
        }
    }
    for (double& value : values) value = std::sqrt(value) * mass_;
    return success();
}

Status OpenpmdSpecies::readWeight(std::uint64_t begin, Values values) const {
    if (!weighting_ && !charge_) {
        std::fill(values.begin(), values.end(), 1.0);
        return success();
    }
    MOTE_RETURN_IF_ERROR((weighting_ ? *weighting_ : *charge_).read(begin, values));
    for (double& value : values) value = std::abs(value);
    return success();
}

Status OpenpmdSpecies::readLost(std::uint64_t begin, std::span<std::uint8_t> lost) const {
    std::vector<double> status(lost.size());
    MOTE_RETURN_IF_ERROR(status_->read(begin, status));
    // Of openPMD's beam physics: 1 live, 0 at the cathode, which is not lost.
    for (std::size_t i = 0; i < lost.size(); ++i) lost[i] = status[i] == 1.0 || status[i] == 0.0 ? 0 : 1;
    return success();
}

// What the particles of a species are, and of which time: from its records, its attributes and its name, in
// this order.

/// What one particle has, from a record that may be of macro-particles: that of the first of them; 0 where
/// there is none.
Result<double> OpenpmdSpecies::ofFirst(const std::optional<OpenpmdComponent>& record, const char* what) {
    if (!record || rows_ == 0) return 0.0;
    std::array<double, 2> ends{};
    for (std::size_t i = 0; i < 2; ++i) {
        const std::uint64_t row = i == 0 ? 0 : rows_ - 1;
        double weighting = 1.0;
        MOTE_RETURN_IF_ERROR(record->read(row, {&ends[i], 1}));
        if (record->weightingPower() != 0.0) {
            if (!weighting_) {
                return notFound(record->where(), "is of macro-particles, but 'weighting' is missing");
            }
            MOTE_RETURN_IF_ERROR(weighting_->read(row, {&weighting, 1}));
        }
        ends[i] /= std::pow(weighting, record->weightingPower());
    }
    if (std::abs(ends[0] - ends[1]) > sameInSingle * std::abs(ends[0])) {
        notes_.push_back("the particles differ in " + std::string(what) +
                         "; that of the first is taken for all");
    }
    return std::isfinite(ends[0]) ? ends[0] : 0.0;
}

Status OpenpmdSpecies::findSpecies(const H5Object& group, const H5Object& iteration) {
    const std::string groupName = group.where.substr(group.where.rfind('/') + 1);
    std::optional<std::string> type;
    for (const H5Object* object : {&group, &iteration}) {
        MOTE_ASSIGN_OR_RETURN(auto own, textAttribute(*object, "speciesType"));
        if (!type && own && *own != "other") type = std::move(own);
    }
    const auto known = speciesOf(type.value_or(groupName));
    if (known) species_ = known->name;
    if (type && !known) species_ = *type;
    MOTE_ASSIGN_OR_RETURN(const double mass, ofFirst(massRecord_, "mass"));
    MOTE_ASSIGN_OR_RETURN(const double charge, ofFirst(chargeRecord_, "charge"));
    const bool hasMass = reference_ ? reference_->mass > 0.0 : mass > 0.0;
    mass_ = hasMass ? (reference_ ? reference_->mass : mass * massInEv) : known ? known->mass : 0.0;
    particleCharge_ = charge != 0.0 ? charge : known ? known->charge : 0.0;
    if (!hasMass && known && !type && known->mass > 0.0)
        notes_.push_back("the mass is that of species '" + groupName + "', after the name of its group");
    if (!hasMass && type && !known) notes_.push_back("the mass of species '" + *type + "' is not known");
    checkSpecies(known, type ? *type : groupName);
    // A record says what the name of a nuclide leaves open: these are neutral.
    const bool open = species_.starts_with('#') && species_.find_first_of("+-") == std::string::npos;
    if (chargeRecord_ && rows_ > 0 && charge == 0.0 && open) species_ += "+0";
    if (massRecord_ && rows_ > 0 && mass == 0.0 && charge == 0.0 && !known && !type) species_ = "photon";
    return success();
}

/// Records go before names: a group "electrons" of particles with charge +e holds positrons.
void OpenpmdSpecies::checkSpecies(const std::optional<KnownSpecies>& named, const std::string& name) {
    const bool chargeFits =
        !named || !named->chargeKnown || std::abs(particleCharge_ - named->charge) < 0.01 * elementaryCharge;
    const bool massFits = !named || std::abs(mass_ - named->mass) <= 1e-3 * named->mass;
    if (named && chargeFits && massFits) return;
    const auto found = particleCharge_ != 0.0 ? speciesOf(mass_, particleCharge_) : std::nullopt;
    if (found && named && found->name != named->name) {
        notes_.push_back("the species is " + found->name +
                         ", after its mass and charge, though it is called '" + name + "'");
    }
    if (found) species_ = found->name;
    if (!found && named) species_.clear();
}

/// The mass that the user gives is used where the file does not say one, and refused where it says another.
Status OpenpmdSpecies::takeMass(double wanted) {
    if (!(wanted > 0.0)) return success();
    if (mass_ == 0.0) {
        mass_ = wanted;
        return success();
    }
    if (std::abs(wanted - mass_) <= sameMass * mass_) return success();
    return Error{
        ErrorCode::invalidArgument, "mass",
        "the file says that its particles have " + std::to_string(mass_) + " eV/c^2; leave the mass out"};
}

/// That of the iteration, else the offset of the particles' times, else these: the mean of the first of them.
Status OpenpmdSpecies::findTime(const H5Object& iteration) {
    if (reference_) {
        time_ = reference_->time;
        return success();
    }
    MOTE_ASSIGN_OR_RETURN(const auto time, numberAttribute(iteration, "time"));
    MOTE_ASSIGN_OR_RETURN(const auto unit, numberAttribute(iteration, "timeUnitSI"));
    if (time.has_value()) {
        time_ = *time * unit.value_or(1.0);
    } else if (timeRecord_.offset && rows_ > 0) {
        double first = 0.0;
        MOTE_RETURN_IF_ERROR(timeRecord_.offset->read(0, {&first, 1}));
        time_ = first;
    } else if (timeRecord_.value && rows_ > 0) {
        std::vector<double> values(std::min(rows_, rowsForTime));
        MOTE_RETURN_IF_ERROR(readQuantity(timeRecord_, 0, values));
        double sum = 0.0, count = 0.0;
        for (const double value : values) {
            if (!std::isfinite(value)) continue;
            sum += value - values.front();
            count += 1.0;
        }
        if (count > 0.0 && std::isfinite(values.front())) time_ = values.front() + sum / count;
    }
    if (time_ && !std::isfinite(*time_)) time_.reset();
    return success();
}

// What a species has besides the records that make the columns of a run: spin, charge state, turn and
// whatever its writer thought of, under its own name and in its own unit.

/// Those that have a number for each particle; what cannot be read as such is passed by, as nobody asked for
/// it.
Status OpenpmdSpecies::openOthers(const H5File& file, const H5Object& group) {
    MOTE_ASSIGN_OR_RETURN(const auto children, file.children(group));
    const auto add = [&](const std::string& record, const std::string& component) {
        const auto name = recordOf(component.empty() ? record : fmt::format("{}_{}", record, component));
        if (!name || recordNames_.size() == mostLookedAt) return;
        auto opened = OpenpmdComponent::open(file, group, record, component);
        if (!opened.ok() || !opened->has_value()) return;
        if ((*opened)->rows().value_or(rows_) != rows_) return;
        recordNames_.push_back({name->name, unitOfPowers((*opened)->unitDimension())});
        records_.push_back(std::move(**opened));
    };
    for (const auto& record : std::span(children).first(std::min(children.size(), mostLookedAt))) {
        if (std::ranges::find(known, record) != known.end()) continue;
        const auto object = file.find(group, record);
        if (!object.ok() || !object->has_value()) continue;
        add(record, "");
        if (!(*object)->group || (!recordNames_.empty() && recordNames_.back().name == record)) continue;
        const auto components = file.children(**object);
        if (!components.ok()) continue;
        for (const auto& component : std::span(*components).first(std::min(components->size(), mostLookedAt)))
            add(record, component);
    }
    return success();
}

// How many particles a species has, and which of its records do not fit that.

/// What cannot be read is missing, and said so: one odd record is no reason to give up a run. Where nothing
/// else is there, its error is that of the step.
Status OpenpmdSpecies::drop(const std::string& record, const Error& error) {
    if (error.code == ErrorCode::cancelled) return error;
    if (!problem_) problem_ = error;
    notes_.push_back("record '" + record + "' is left out: " + error.message);
    constexpr std::pair<std::string_view, Column> columns[] = {
        {"position/x", Column::x},  {"position/y", Column::y},  {"position/z", Column::z},
        {"momentum/x", Column::px}, {"momentum/y", Column::py}, {"momentum/z", Column::pz},
        {"time", Column::t}};
    for (const auto& [name, column] : columns) {
        if (name == record) broken_[static_cast<std::size_t>(column)] = true;
    }
    return success();
}

/// How many rows most records have, empty ones left out; equally many of two lengths are a contradiction.
Result<std::uint64_t> OpenpmdSpecies::mostRows(const std::vector<Member>& all) const {
    std::map<std::uint64_t, std::size_t> lengths;
    for (const Member& member : all) {
        if (member.get().constant()) continue;
        ++lengths[*member.get().rows()];
    }
    std::uint64_t rows = 0;
    std::size_t most = 0;
    for (const auto& [length, count] : lengths) {
        if (length == 0 || count <= most) continue;
        most = count;
        rows = length;
    }
    const auto rival = std::find_if(lengths.begin(), lengths.end(), [&](const auto& other) {
        return other.first != 0 && other.first != rows && other.second == most;
    });
    if (rival == lengths.end()) return rows;
    for (const Member& member : all) {
        if (member.get().constant() || *member.get().rows() != rival->first) continue;
        return Error{
            ErrorCode::corrupt, member.get().where(),
            "has " + std::to_string(rival->first) + " values where others have " + std::to_string(rows)};
    }
    return rows;
}

std::vector<OpenpmdSpecies::Member> OpenpmdSpecies::members() {
    std::vector<Member> all;
    const auto add = [&](std::string name, std::optional<OpenpmdComponent>& component, Quantity* quantity) {
        if (component) all.push_back({std::move(name), &component, quantity});
    };
    std::vector<Quantity*> quantities;
    for (auto* group : {&position_, &momentum_}) {
        for (Quantity& quantity : *group) quantities.push_back(&quantity);
    }
    quantities.insert(quantities.end(), {&positionT_, &momentumT_, &timeRecord_, &total_});
    for (Quantity* quantity : quantities) {
        add(quantity->name, quantity->value, quantity);
        add(quantity->name, quantity->offset, quantity);
    }
    add("weighting", weighting_, nullptr);
    add("weight", charge_, nullptr);
    add("particleStatus", status_, nullptr);
    add("id", id_, nullptr);
    add("mass", massRecord_, nullptr);
    add("charge", chargeRecord_, nullptr);
    return all;
}

OpenpmdSpecies::Kept OpenpmdSpecies::kept() {
    Kept kept;
    const auto add = [&](const OpenpmdComponent& component) {
        kept.first += component.keptBytes(1);
        kept.more += component.keptBytes(2) - component.keptBytes(1);
    };
    for (const Member& member : members()) add(member.get());
    for (const auto& record : records_) add(record);
    return kept;
}

/// Whether all that read() reads of can be read by several threads at once.
bool OpenpmdSpecies::findWhetherAtOnce() {
    const auto all = members();
    return std::ranges::all_of(all,
                               [&](const Member& member) {
                                   if (member.component == &massRecord_ || member.component == &chargeRecord_)
                                       return true;
                                   return member.component == &id_ ? member.get().readsIntegersAtOnce()
                                                                   : member.get().readsAtOnce();
                               }) &&
           std::ranges::all_of(records_, &OpenpmdComponent::readsAtOnce);
}

/// The number of particles. A constant has its value whatever its shape says, so shapes count only where
/// nothing else does. A record that is longer or shorter than the others is left out.
Status OpenpmdSpecies::checkRows() {
    const std::vector<Member> all = members();
    if (all.empty() && problem_) return *problem_;
    const bool constants =
        std::all_of(all.begin(), all.end(), [](const Member& member) { return member.get().constant(); });
    if (constants) return takeConstantRows(all);
    MOTE_ASSIGN_OR_RETURN(rows_, mostRows(all));
    for (const Member& member : all) {
        if (!member.component->has_value() || member.get().constant()) continue;
        const std::uint64_t rows = *member.get().rows();
        if (rows == rows_) continue;
        const Error error{ErrorCode::corrupt, member.get().where(),
                          rows == 0 ? "is empty"
                                    : "has " + std::to_string(rows) + " values where there are " +
                                          std::to_string(rows_) + " particles"};
        MOTE_RETURN_IF_ERROR(drop(member.name, error));
        if (member.quantity != nullptr)
            *member.quantity = {};
        else
            member.component->reset();
    }
    return success();
}

Status OpenpmdSpecies::takeConstantRows(const std::vector<Member>& all) {
    const OpenpmdComponent* longest = nullptr;
    for (const Member& member : all) {
        if (!member.get().rows()) continue;
        if (longest == nullptr || *member.get().rows() > *longest->rows()) longest = &member.get();
    }
    if (longest == nullptr) return success();
    rows_ = *longest->rows();
    if (rows_ <= maxConstantRows) return success();
    return corrupt(longest->where(),
                   "declares " + std::to_string(rows_) + " particles, but every record is a constant");
}

}  // namespace mote::prep
