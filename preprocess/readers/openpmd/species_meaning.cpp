// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the particles of a species are, and of which time: from its records, its attributes and its name, in
// this order.
#include <array>
#include <cmath>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/hdf5/h5_attribute.h"
#include "preprocess/readers/known_species.h"
#include "preprocess/readers/openpmd/species.h"

namespace mote::prep {
namespace {

constexpr double sameInSingle = 1e-5;  // macro-particles store mass, charge and weighting in single precision
constexpr double sameMass = 1e-6;      // as who types it means the same
constexpr std::uint64_t rowsForTime = 1u << 16;

}  // namespace

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

}  // namespace mote::prep
