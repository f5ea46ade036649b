// SPDX-License-Identifier: GPL-3.0-or-later
//
// PlotAxis: a quantity of a run that is read in chunks: what a plot can have along an axis, and what can be
// kept as a column. An immutable value and pure functions.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/readers/particle_source.h"
#include "protocol/base/error.h"
#include "protocol/quantity/quantity.h"

namespace mote::prep {

class PlotAxis {
  public:
    /// By the name as in --axes: what a particle of the run has a number of (docs/NUMBERS.md). Errors, at
    /// "axis NAME": as Quantity::make.
    static Result<PlotAxis> make(std::string_view name, const ParticleSource& source);

    const std::string& name() const { return quantity_.name(); }
    const std::string& unit() const { return quantity_.unit(); }
    /// What it is made from, weights of means aside.
    const std::vector<Column>& columns() const { return columns_; }
    /// Whether its values are a column as it is.
    bool isColumn() const { return quantity_.isColumn(); }
    /// Whether the means of the step's particles are needed.
    bool needsMeans() const { return quantity_.needsMeans(); }

    /// The value of each of the chunk's particles; not finite if it has none (px/pz at pz = 0). `out` has
    /// the chunk's size. Uses all threads of the calling arena.
    void evaluate(const ParticleChunk& chunk, const BeamContext& context, std::span<double> out) const;

  private:
    Quantity quantity_;
    std::vector<Column> columns_;
};

using PlotAxes = std::array<PlotAxis, 3>;

/// What a run has of columns, in the order of Column.
std::vector<Column> columnsOf(const ParticleSource& source);
/// The name in messages, datasets and expressions.
std::string columnName(Column column, const ParticleSource& source);

/// What formulas need of a run, but for its means.
BeamContext contextOf(const ParticleSource& source);

}  // namespace mote::prep
