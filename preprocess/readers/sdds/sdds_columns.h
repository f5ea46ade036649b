// SPDX-License-Identifier: GPL-3.0-or-later
//
// SddsColumns: what the columns of an SDDS data set mean for a run: those of elegant (x, xp, y, yp, t, p, dt,
// particleID) and those named as in tables, and how particles come out of them. A value, made once a file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/sdds/sdds_header.h"
#include "preprocess/readers/sdds/sdds_pages.h"

namespace mote::prep {

class SddsColumns {
  public:
    /// `mass` in eV/c^2, 0: the electron's where the data set measures in m c or writes as elegant does.
    /// Errors, naming file and column: unsupported (an unknown unit, a text), corrupt (nothing of a particle,
    /// two columns of one meaning), invalidArgument.
    static Result<SddsColumns> of(const SddsHeader& header, double mass, const std::string& file);

    bool has(Column column) const;
    double mass() const { return mass_; }
    /// Whether z is found from the times at which particles pass.
    bool zFromTime() const;
    /// Whether a row is a ring of a cylindrical code (spiffe: r, pr, pphi), which becomes one particle.
    bool rings() const { return r_ && pr_ && !item(Column::x); }
    /// Whether the electron's mass was taken because none was given.
    bool massAssumed() const { return massAssumed_; }
    double chargeFactor() const { return chargeFactor_; }  ///< of the parameter Charge, into C

    /// Every column of numbers under its name and in its unit, but those called as a known quantity.
    const std::vector<SourceRecord>& records() const { return records_; }
    /// The number of the column of a record that it has.
    std::size_t recordColumn(const std::string& name) const;

    /// The numbers of the columns of the file that `wanted` need, without those of ids and records.
    std::vector<std::size_t> needed(const std::vector<Column>& wanted) const;
    std::optional<std::size_t> idColumn() const { return id_; }
    std::optional<std::size_t> timeColumn() const;
    double timeFactor() const;  ///< into s
    /// Fills the wanted columns but weight of the source's parameters, id and records, and what is lost.
    /// `rows` holds the columns of needed(wanted), and more behind them; `meanTime` in s, of the page.
    void fill(const std::vector<Column>& wanted, const SddsRows& rows, double meanTime,
              ParticleChunk& chunk) const;

  private:
    struct Item {
        std::size_t column = 0;
        double factor = 1.0;
    };
    struct Lost {
        std::size_t column = 0;
        FieldMeaning::Kind kind = FieldMeaning::Kind::lost;
    };

    Status add(const SddsHeader& header, std::size_t column, const std::string& file);
    Status addElegant(const SddsField& field, std::size_t column, const std::string& where);
    Status addRing(const SddsField& field, std::size_t column, const std::string& where);
    /// The values of an item, in the run's unit.
    struct Values {
        const double* at = nullptr;
        double factor = 1.0;
        double operator[](std::size_t row) const { return at[row] * factor; }
    };
    /// Where the columns of needed() lie.
    struct Rows;

    bool slopes() const { return xp_ && yp_ && p_; }
    const std::optional<Item>& item(Column column) const { return items_[static_cast<std::size_t>(column)]; }
    bool momenta() const;
    void fillMomentum(Column column, const Rows& rows, std::uint64_t begin,
                      std::vector<double>& values) const;
    void fillRing(Column column, const Rows& rows, std::uint64_t begin, std::vector<double>& values) const;
    void fillPlaces(const Rows& rows, double meanTime, std::uint64_t begin,
                    std::vector<double>& values) const;

    std::optional<Item> items_[columnCount - 1];  // by Column, up to weight
    std::optional<Item> xp_, yp_, p_, dt_, r_, pr_, pphi_;
    std::optional<std::size_t> id_;
    std::vector<Lost> lost_;
    std::vector<SourceRecord> records_;
    std::vector<std::size_t> recordColumns_;  ///< by record
    double mass_ = 0.0, chargeFactor_ = 1.0;
    bool massAssumed_ = false;
};

}  // namespace mote::prep
