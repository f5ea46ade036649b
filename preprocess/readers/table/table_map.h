// SPDX-License-Identifier: GPL-3.0-or-later
//
// TableMap: what a user says of a table's columns: "x=X [mm],px=PX [MeV/c]". A value.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "preprocess/readers/table/table_columns.h"
#include "protocol/base/error.h"

namespace mote::prep {

class TableMap {
  public:
    /// Entries with commas between: a quantity, '=', and a column by its name or its number (from 1), or a
    /// number, perhaps with a unit. An empty text maps nothing. Error: invalidArgument, at "map".
    static Result<TableMap> parse(std::string_view text);

    bool empty() const { return entries_.empty(); }
    /// Whether every column that is not given by its number is among the names, units left out.
    bool fits(const std::vector<std::string>& names) const;
    /// The fields of a table as the map names them, those that it does not name left out. A unit of the map
    /// goes before one of the table. Errors, at "map": notFound (a column that is not there),
    /// invalidArgument.
    Status apply(const std::vector<std::string>& names, std::vector<TableField>& fields,
                 std::vector<TableConstant>& constants) const;

  private:
    struct Entry {
        std::string quantity, column, unit;  ///< the unit with its brackets, or ""
    };
    std::vector<Entry> entries_;
};

}  // namespace mote::prep
