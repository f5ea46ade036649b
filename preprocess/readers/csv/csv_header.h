// SPDX-License-Identifier: GPL-3.0-or-later
//
// CsvHeader: the line of names of a table in text; comma, semicolon, tab or blanks between the fields.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/readers/table/table_columns.h"
#include "preprocess/readers/table/table_map.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// What a user says of a table.
struct CsvOptions {
    double mass = 0.0;  ///< eV/c^2, 0: as the table says
    TableMap map;
};

/// The lines of a table that name its columns. Values and functions without state.
struct CsvHeader {
    char separator = ',';            ///< ' ': runs of blanks
    std::vector<std::string> names;  ///< of the fields of a row, with their units
    std::uint64_t rows = 0;          ///< lines over the table that are no comments
    std::string where;               ///< of the names, for messages

    TableColumns columns;
};

/// The header of a file: the last line over the numbers that names columns, in a comment or not, perhaps with
/// a line of units below it. With a map, the line that has the map's names, or none where it has numbers.
/// Errors: those of TableColumns::of, TableMap::apply and LineReader; notFound (no such line).
Result<CsvHeader> readCsvHeader(const std::filesystem::path& path, const CsvOptions& options);

}  // namespace mote::prep
