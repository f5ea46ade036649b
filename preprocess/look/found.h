// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a foreign file holds, as people and scripts are told of it. Values; any thread.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <variant>
#include <vector>

namespace mote::prep {

/// One thing that is known: a member of the JSON object, and a line for people.
struct Fact {
    using Value = std::variant<std::string, double, std::uint64_t, bool, std::vector<double>,
                               std::vector<std::int64_t>, std::vector<std::uint64_t>>;
    std::string name;  ///< of the member
    Value value;
    std::string label = {}, text = {};  ///< of the line; "": there is none
};

/// A column of a run, or the values of a volume, in the units that a dataset would have.
struct FoundColumn {
    std::string name, unit;
    double low = std::numeric_limits<double>::quiet_NaN();  ///< of the finite values; NaN: there are none
    double high = std::numeric_limits<double>::quiet_NaN();
    std::uint64_t invalid = 0;  ///< values that are not finite

    /// Takes the value into the range.
    void take(double value) {
        if (!(value - value == 0.0)) {
            ++invalid;
            return;
        }
        if (!(value >= low)) low = value;
        if (!(value <= high)) high = value;
    }
};

/// One thing that a file can be read as.
struct Found {
    std::string kind;    ///< "particles", "volume", "mesh" or "image"
    std::string format;  ///< as in --format
    std::string told;    ///< what told the format
    std::string name;    ///< a species or field, if the file has several; else ""
    std::vector<Fact> facts;
    std::vector<FoundColumn> columns;
    std::vector<std::string> notes;    ///< what is assumed
    std::vector<std::string> refused;  ///< why it would not be prepared, though its header can be read
};

/// All of an input.
struct Look {
    std::string input;
    std::vector<Found> found;
    std::vector<std::string> refused;  ///< why it is not read, or not as something else

    bool whole() const {
        for (const Found& each : found) {
            if (!each.refused.empty()) return false;
        }
        return !found.empty() && refused.empty();
    }
};

/// Writes one JSON object, on one line with its end.
std::string jsonLine(const Look& look);
/// Lines for people, not yet fit for a terminal (toTerminalLines).
std::string lookText(const Look& look);

}  // namespace mote::prep
