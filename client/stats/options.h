// SPDX-License-Identifier: GPL-3.0-or-later
//
// The command line of mote-stats. A value.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "protocol/mote.pb.h"

namespace mote::client {

/// How numbers are told.
enum class NumbersForm {
    table,  ///< for people, on stdout
    json,   ///< one JSON object a step on stdout
    csv,    ///< a file
    npy,    ///< a file
};

struct StatsOptions {
    std::string dataset;                           ///< "ROOT/NAME"
    std::optional<std::filesystem::path> connect;  ///< a running server's connection file, or
    std::vector<std::string> roots;                ///< "NAME=DIR" of the private server to start
    std::string steps;                             ///< "FIRST:LAST:STRIDE"; "": all
    std::filesystem::path select;                  ///< a file with a Selection; empty: all particles
    std::vector<std::string> columns;              ///< none: all
    std::optional<proto::HistogramQuery> histogram;
    /// A column, how many slices along it, and of what they are equal; no column: there are none.
    struct Slices {
        std::string column;
        std::optional<std::uint32_t> count = {};
        std::string of = {};  ///< as StatisticsQuery::slices_of
    } slices;
    /// Over what a histogram's bins reach if nothing is said.
    enum class BoundsOf { run, step, selection } boundsOf = BoundsOf::run;
    std::optional<NumbersForm> form;  ///< nothing: a table, or where there is an export no numbers
    std::filesystem::path file;       ///< of CSV and NPY
    std::filesystem::path exported;   ///< the file of an export; empty: there is none
    bool quiet = false;               ///< no progress on stderr

    bool wantsNumbers() const { return form || histogram || exported.empty(); }
};

/// The options, or the exit status after help (0) or wrong usage (2), which has been printed.
std::variant<StatsOptions, int> parseStatsOptions(int argc, const char* const* argv);

}  // namespace mote::client
