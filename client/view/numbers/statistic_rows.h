// SPDX-License-Identifier: GPL-3.0-or-later
//
// StatisticRows: statistics of a step and of a selection as lines of a table, and of all steps as the points
// of a plot. Pure functions.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/shared/numbers.h"
#include "client/shared/statistic_name.h"
#include "protocol/mote.pb.h"

namespace mote::client {

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

/// Of the whole steps, by step; empty where the dataset has no such statistic.
std::vector<double> seriesOf(const proto::ParticlesManifest& manifest, const std::string& statistic);

}  // namespace mote::client
