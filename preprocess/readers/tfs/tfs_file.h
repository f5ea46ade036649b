// SPDX-License-Identifier: GPL-3.0-or-later
//
// TfsFile: a table in TFS, as MAD-X and PTC write it: "@" lines with what is said of all rows, "*" names, "$"
// types, "#segment" lines between the steps. A value.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/readers/table/held_source.h"
#include "protocol/scene/error.h"

namespace mote::prep {

struct TfsFile {
    std::string name;                         ///< of the file
    std::map<std::string, std::string> says;  ///< of "@" lines, by names in capitals
    std::vector<std::string> names;           ///< of the columns kept, in capitals
    std::vector<std::vector<double>> values;  ///< by name
    std::vector<std::size_t> segments;        ///< the rows before which one begins

    const std::vector<double>* find(std::string_view name) const;
    std::optional<double> number(const std::string& name) const;  ///< of an "@" line

    /// Keeps the columns of tracks. Errors: corrupt (a row without a number, no names), those of LineReader,
    /// cancelled.
    static Result<TfsFile> read(const HeldFile& held);
};

}  // namespace mote::prep
