// SPDX-License-Identifier: GPL-3.0-or-later
//
// JsonNumbers: the objects of a JSON text that hold lists of numbers, as Python's json writes them (NaN and
// Infinity too). All else is checked and stepped over. A function without state.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/scene/error.h"

namespace mote::prep {

/// One object: its members that are numbers or lists of numbers (also of lists, row by row).
struct JsonNumbers {
    std::map<std::string, std::vector<double>> lists;
    std::map<std::string, double> numbers;

    /// All objects of a text with a list in them, in the order in which they end. Errors, with `name` and the
    /// byte: corrupt (no JSON, nested deeper than 32), resourceExhausted (more than 2^27 numbers).
    static Result<std::vector<JsonNumbers>> parse(std::string_view text, const std::string& name);
};

}  // namespace mote::prep
