// SPDX-License-Identifier: GPL-3.0-or-later
//
// OpenpmdSpecies: one species in one iteration of an openPMD file, its records turned into the columns of a
// run. Owned by the source; used from one thread at a time, unless it says otherwise. It keeps its file open.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "preprocess/readers/hdf5/h5_file.h"
#include "preprocess/readers/known_species.h"
#include "preprocess/readers/openpmd/component.h"
#include "preprocess/readers/particle_source.h"

namespace mote::prep {

class OpenpmdSpecies {
  public:
    /// The group at `path`; `iterationPath` is asked for what the group does not say, and `mass` (eV/c^2, 0:
    /// none) is used where nobody says it. Errors: invalidArgument (the file says another mass), notFound,
    /// corrupt (records of different lengths), unsupported.
    static Result<OpenpmdSpecies> open(const H5File& file, const std::string& path,
                                       const std::string& iterationPath, double mass);

    std::uint64_t rows() const { return rows_; }
    bool has(Column column) const;
    /// Whether the column is missing only because its record cannot be read: read() fills it with NaN.
    bool broken(Column column) const { return broken_[static_cast<std::size_t>(column)] && !has(column); }
    /// What there is besides: "spin_x", "chargeState".
    const std::vector<SourceRecord>& records() const { return recordNames_; }
    double mass() const { return mass_; }  ///< eV/c^2; 0: unknown
    /// As those of ParticleSource.
    const std::string& species() const { return species_; }
    double particleCharge() const { return particleCharge_; }
    /// As ParticleSource::weightUnit.
    std::string weightUnit() const { return weighting_ ? "1" : charge_ ? "C" : ""; }
    std::optional<double> time() const { return time_; }  ///< s, of the iteration
    const std::vector<std::string>& notes() const { return notes_; }

    /// Whether several threads may read() at once.
    bool readsAtOnce() const { return readsAtOnce_; }
    /// As ParticleSource::keptBytes: of one thread, and of each more.
    struct Kept {
        std::uint64_t first = 0, more = 0;
    };
    Kept kept();
    /// As SeriesSource::readRows, the records of `names`.
    Status read(const std::vector<Column>& wanted, const std::vector<SourceRecord>& names,
                ParticleChunk& chunk) const;

  private:
    struct Quantity {
        std::string name;                               ///< "position/x"
        std::optional<OpenpmdComponent> value, offset;  ///< they add up
    };
    /// A component and what it belongs to.
    struct Member {
        std::string name;
        std::optional<OpenpmdComponent>* component = nullptr;
        Quantity* quantity = nullptr;
        const OpenpmdComponent& get() const { return **component; }
    };

    Status openRecords(const H5File& file, const H5Object& group);
    Status openQuantity(const H5File& file, const H5Object& group, Quantity& quantity, const char* record,
                        const char* offset, const char* component);
    Status drop(const std::string& record, const Error& error);
    Status openOthers(const H5File& file, const H5Object& group);
    std::vector<Member> members();
    bool findWhetherAtOnce();
    Result<std::uint64_t> mostRows(const std::vector<Member>& all) const;
    Status takeConstantRows(const std::vector<Member>& all);
    Status checkRows();
    Status checkMomentumUnits() const;
    Result<double> ofFirst(const std::optional<OpenpmdComponent>& record, const char* what);
    Status findSpecies(const H5Object& group, const H5Object& iteration);
    void checkSpecies(const std::optional<KnownSpecies>& named, const std::string& name);
    Status takeMass(double wanted);
    Status findTime(const H5Object& iteration);

    using Values = std::span<double>;  ///< of rows from `begin` on
    Status readColumn(Column column, std::uint64_t begin, Values values) const;
    static Status add(const OpenpmdComponent& offset, std::uint64_t begin, Values values);
    Status divideByWeighting(double power, std::uint64_t begin, Values values) const;
    Status readQuantity(const Quantity& quantity, std::uint64_t begin, Values values) const;
    Status readMomentum(const Quantity& quantity, std::uint64_t begin, Values values) const;
    Status readLongitudinalFromTotal(std::uint64_t begin, Values values) const;
    Status readReferenceColumn(Column column, std::uint64_t begin, Values values) const;
    Status readWeight(std::uint64_t begin, Values values) const;
    Status readRecord(const std::string& name, std::uint64_t begin, Values values) const;
    Status readLost(std::uint64_t begin, std::span<std::uint8_t> lost) const;

    std::uint64_t rows_ = 0;
    double mass_ = 0.0, particleCharge_ = 0.0;
    std::string species_;
    std::optional<double> time_;
    std::vector<std::string> notes_;
    std::optional<Error> problem_;  ///< the first record that was left out
    bool broken_[columnCount] = {};
    std::array<Quantity, 3> position_, momentum_;
    Quantity positionT_, momentumT_;  ///< instead of z, relative to the reference particle (ImpactX)
    Quantity timeRecord_, total_;
    std::optional<OpenpmdComponent> weighting_, charge_, status_, id_, massRecord_, chargeRecord_;
    std::optional<ReferenceParticle> reference_;
    std::vector<SourceRecord> recordNames_;
    std::vector<OpenpmdComponent> records_;  ///< by name
    bool readsAtOnce_ = false;
};

}  // namespace mote::prep
