// SPDX-License-Identifier: GPL-3.0-or-later
//
// Statistic: a number that a set of particles has: its name, its unit, what it is of and how it is defined.
// One table for all who compute, ask for, tell or draw statistics; that of docs/NUMBERS.md is printed from
// it. Pure functions.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/quantity/known_quantity.h"

namespace mote {

struct Statistic {
    std::string name;
    std::string unit;             ///< "m", "eV/c", "m eV/c", "m^2", "1/m", "C", ...; "1" where it has none
    std::vector<std::string> of;  ///< the quantities that its name tells of: x and px of "cov_x__px"
    std::vector<std::string> columns;  ///< of a run that it is made from, weights aside
    /// Its name and its definition as those have it that differ by a quantity alone: "norm_emit_U". In place
    /// of Q, A and B stand quantities, of U x, y and z, of V x and y; <...> is the weighted mean about the
    /// mean.
    std::string_view family, definition;
};

/// All that every run has, in a fixed order: that of a manifest's statistic_names.
std::span<const Statistic> statistics();
/// The index of a statistic, by its name; a covariance also with its two names changed about.
std::optional<std::size_t> findStatistic(std::string_view name);

/// "mean_Q", "sigma_Q", "min_Q" and "max_Q" of any quantity Q, an expression too, and "cov_A__B".
struct QuantityStatistic {
    std::string_view kind;  ///< "mean", "sigma", "min", "max" or "cov"
    std::vector<std::string> quantities;

    /// Its unit, where the quantities have these; "" where that cannot be told.
    std::string unit(std::span<const std::string> units) const;
};
/// What such a name says; nothing where it is another.
std::optional<QuantityStatistic> parseQuantityStatistic(std::string_view name);

/// Sets the means of a context by the statistics mean_x ... mean_pz and mean_p, of which one that is not
/// known is NaN.
void setMeans(const std::function<double(std::string_view name)>& statistic, BeamContext& context);

}  // namespace mote
