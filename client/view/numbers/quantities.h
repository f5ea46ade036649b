// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a particle of a dataset has a number of: its columns, and what a server derives from them
// (docs/NUMBERS.md). Pure functions; a manifest that nobody has checked does no harm.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/shared/numbers.h"
#include "client/view/knot_curve.h"
#include "protocol/mote.pb.h"

namespace mote::client {

struct Quantity {
    std::string name;
    std::string unit;
    std::optional<Interval> range = {};  ///< of all steps; none of what is derived, or has no extent
};

/// Columns in the dataset's order, then what can be derived from them; none of a dataset without columns.
std::vector<Quantity> quantitiesOf(const proto::ParticlesManifest& manifest);

/// Null if there is none of this name.
const Quantity* findQuantity(const std::vector<Quantity>& quantities, std::string_view name);

/// A statistic of a step and of a selection, as a line of a table.
struct StatisticRow {
    std::string name;
    std::string whole, selected;  ///< with their units: "1.2345 mm"; "-": not defined, empty: not known
};

/// Each name of either once, the step's first; or those that are looked at most.
std::vector<StatisticRow> statisticRows(const std::optional<StepStatistics>& whole,
                                        const std::optional<StepStatistics>& selected,
                                        const ColumnUnits& units, bool all);

/// The number for people, with its unit.
std::string numberText(double value, std::string_view unit);

/// Returns the statistic of the whole steps, by step; empty if the dataset has no such statistic.
std::vector<double> seriesOf(const proto::ParticlesManifest& manifest, const std::string& statistic);

}  // namespace mote::client
