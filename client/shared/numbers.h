// SPDX-License-Identifier: GPL-3.0-or-later
//
// Answers to queries as values: what a server says of numbers is held to what was asked, and to itself,
// before anything is made of it. Values and pure functions; units as in docs/NUMBERS.md. Errors of all:
// corrupt.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "client/shared/connection.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::client {

struct StepStatistics {
    std::uint32_t step = 0;
    std::int64_t iteration = 0;
    double time = 0.0;  ///< s
    std::vector<std::string> names;
    std::vector<double> values;               ///< by name; NaN: not defined
    std::vector<double> sliceEdges;           ///< one more than slices, or none
    std::vector<std::vector<double>> slices;  ///< each by name
    std::vector<std::string> notes = {};      ///< what limits them, a sentence each
};
Result<StepStatistics> statisticsOf(const QueryAnswer& answer);

struct StepHistogram {
    std::uint32_t step = 0;
    std::vector<std::string> columns;        ///< one or two
    std::vector<std::vector<double>> edges;  ///< of each column, ascending, one more than bins
    std::vector<double> counts;              ///< of the second column fastest
    std::uint64_t particles = 0;             ///< that it rests on
    double outside = 0.0;                    ///< weight beyond the edges
    std::vector<std::string> notes = {};     ///< what limits it, a sentence each

    std::size_t bins(std::size_t column) const { return edges[column].size() - 1; }
};
/// `asked` says which columns, and how many bins they have.
Result<StepHistogram> histogramOf(const QueryAnswer& answer, const proto::HistogramQuery& asked);

/// A piece of a step's columns.
struct StepColumns {
    std::uint32_t step = 0;
    std::uint64_t count = 0;  ///< rows
    /// By name that was asked for: `count` words each, f64, of "id" u64.
    std::vector<std::vector<std::uint64_t>> words;
    std::vector<std::string> units;       ///< by name, or none
    std::uint64_t next = 0;               ///< where the next piece begins; over the one that was asked for
    bool end = false;                     ///< there is none
    std::uint64_t total = 0;              ///< by id: ids of the selection
    std::vector<std::string> notes = {};  ///< what limits them, a sentence each
};
Result<StepColumns> columnsOf(const QueryAnswer& answer, const proto::ColumnsQuery& asked);

/// Statistics of the whole steps, as a dataset has them. Errors: notFound, with how to make them: it was made
/// without.
Result<std::vector<StepStatistics>> statisticsOf(const proto::ParticlesManifest& manifest,
                                                 const std::vector<std::size_t>& steps);

}  // namespace mote::client
