// SPDX-License-Identifier: GPL-3.0-or-later
//
// H5PartStep: the columns of one step of an H5Part file. Owned by the source; one thread at a time.
//
// H5Part itself names no units. OPAL writes them as attributes of the file (xUnit "m", pxUnit "#beta#gamma")
// and of the step (MASS in GeV, TIME in s); where there are none, m, eV/c, s and C are taken.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "preprocess/readers/hdf5/h5_column.h"
#include "preprocess/readers/particle_source.h"

namespace mote::prep {

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

    /// As ParticleSource::read.
    Status read(std::uint64_t begin, std::size_t count, const std::vector<Column>& wanted,
                ParticleChunk& chunk);

  private:
    Status readMeaning(const H5File& file, const H5Object& step);
    Status openColumn(const H5File& file, const H5Object& step, std::size_t column, const char* name);
    Result<double> unitOf(const H5File& file, const H5Object& step, std::size_t column, const char* name);

    std::uint64_t rows_ = 0;
    double mass_ = 0.0, time_ = 0.0;
    bool unitsGiven_ = false;
    std::array<std::optional<H5Column>, columnCount> columns_;
    std::array<double, columnCount> factors_{};
};

}  // namespace mote::prep
