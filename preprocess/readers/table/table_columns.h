// SPDX-License-Identifier: GPL-3.0-or-later
//
// TableColumns: what the fields of a table mean for a run, whatever the file's format is, and how particles
// come out of them: momenta in units of the reference momentum, slopes, velocities, deviations of energy,
// rings of a cylindrical code. A value, made once a table; free of threads once it is made.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "preprocess/readers/particle_source.h"
#include "preprocess/readers/table/table_quantity.h"
#include "protocol/base/error.h"

namespace mote::prep {

/// A named field of a table, with the number under which its values come.
struct TableField {
    std::size_t index = 0;
    std::string name;  ///< "px [MeV/c]"
};

/// A quantity that is the same for all rows.
struct TableConstant {
    TableQuantity quantity = TableQuantity::mass;
    double value = 0.0;
};

class TableColumns {
  public:
    /// Values of the fields of needed(), by the field's number; null for the others.
    using Values = std::vector<const double*>;

    /// `mass` in eV/c^2, 0: as the table says. Errors, at `where`: notFound (no field has a known name),
    /// corrupt (two of one meaning), unsupported (a unit that is not known, momenta in units of a reference
    /// momentum that is nowhere), invalidArgument (m c without a mass).
    static Result<TableColumns> of(const std::vector<TableField>& fields,
                                   const std::vector<TableConstant>& constants, double mass,
                                   const std::string& where);

    bool has(Column column) const;
    double mass() const { return mass_; }
    /// The field that holds the mass, where no number said it: its first value should be given to setMass().
    std::optional<std::size_t> massField() const;
    /// The same of the charge of one particle, and of setCharge().
    std::optional<std::size_t> chargeField() const;
    /// eV/c^2 over the unit of the field.
    void setMass(double fieldValue);
    /// Elementary charges.
    void setCharge(double fieldValue);
    double charge() const { return charge_; }  ///< C, of one particle, with its sign; 0: not known
    /// As ParticleSource::species, where mass and charge are those of one.
    std::string species() const;
    /// As ParticleSource::weightUnit.
    const std::string& weightUnit() const { return weightUnit_; }
    std::optional<std::size_t> idField() const;
    /// Sentences for people: units that are assumed, frames that are the reference particle's.
    const std::vector<std::string>& notes() const { return notes_; }

    /// Takes all fields of a table, by their numbers, for records under their names and in their units, but
    /// those that are called as a known quantity.
    void addRecords(const std::vector<std::string>& names);
    const std::vector<SourceRecord>& records() const { return records_; }
    /// The field of a record that it has.
    std::size_t recordField(const std::string& name) const;

    /// The fields that the wanted columns and what is lost need, in ascending order, without that of ids and
    /// those of records.
    std::vector<std::size_t> needed(const std::vector<Column>& wanted) const;
    /// Fills the wanted columns but id and records, and what is lost, of rows [chunk.begin, + chunk.size).
    void fill(const std::vector<Column>& wanted, const Values& values, ParticleChunk& chunk) const;

  private:
    using Q = TableQuantity;
    struct Item {
        std::optional<std::size_t> field;  ///< nothing: a constant
        double factor = 1.0;               ///< or the constant
        bool relative = false;
    };
    /// The values of an item row by row.
    struct Reader {
        const double* at = nullptr;
        double factor = 0.0;
        double operator[](std::size_t row) const { return at == nullptr ? factor : at[row] * factor; }
    };
    enum class Way : std::uint8_t { none, direct, rings, velocity, slopes, rest };

    Status add(const TableField& field, double mass, const std::string& where);
    Status checkReference(const std::string& where) const;
    void choose();
    void describe();

    const std::optional<Item>& item(Q quantity) const { return items_[static_cast<std::size_t>(quantity)]; }
    bool hasAll(std::initializer_list<Q> quantities) const;
    bool hasReferenceSpeed() const { return item(Q::referenceMomentum) && mass_ > 0.0; }
    /// How the whole momentum is found: the quantity that gives it, or nothing.
    std::optional<Q> wholeMomentum() const;
    std::vector<Q> quantitiesOf(Column column) const;
    Reader reader(Q quantity, const Values& values) const;

    double referenceOf(std::size_t row, const Values& values) const;
    void fillColumn(Column column, const Values& values, ParticleChunk& chunk) const;
    void fillPlace(Column column, const Values& values, ParticleChunk& chunk) const;
    void fillMomenta(const Values& values, std::size_t begin, std::array<std::vector<double>, 3>& p) const;
    void fillMomentum(const Values& values, std::vector<double>& whole) const;
    void fillRings(const Values& values, std::size_t begin, std::array<std::vector<double>, 3>& p) const;
    void fillLost(const Values& values, ParticleChunk& chunk) const;

    std::array<std::optional<Item>, tableQuantityCount> items_;
    std::vector<SourceRecord> records_;
    std::vector<std::size_t> recordFields_;  ///< by record
    Way transverse_ = Way::none, longitudinal_ = Way::none;
    double mass_ = 0.0, charge_ = 0.0;
    std::string weightUnit_;
    std::vector<std::pair<std::string, std::string>> assumed_;  ///< field, unit
    std::vector<std::string> notes_;
    bool weightNamed_ = false;
};

}  // namespace mote::prep
