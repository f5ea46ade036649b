// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/table/table_map.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "preprocess/readers/text/number.h"

namespace mote::prep {
namespace {

constexpr std::size_t maxEntries = 64;

/// Where an entry ends: at a comma that stands in no brackets.
std::size_t entryEnd(std::string_view text) {
    int depth = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '[' || text[i] == '(') ++depth;
        if (text[i] == ']' || text[i] == ')') --depth;
        if (text[i] == ',' && depth <= 0) return i;
    }
    return text.size();
}

/// "X [mm]" as "X" and "[mm]".
std::pair<std::string_view, std::string_view> splitUnit(std::string_view name) {
    name = trim(name);
    const std::size_t open = name.find_first_of("[({");
    if (open == std::string_view::npos || open == 0) return {name, ""};
    if (std::string_view("])}").find(name.back()) == std::string_view::npos) return {name, ""};
    return {trim(name.substr(0, open)), name.substr(open)};
}

std::optional<std::size_t> columnNamed(const std::vector<std::string>& names, std::string_view wanted) {
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i] == wanted) return i;
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (splitUnit(names[i]).first == wanted) return i;
    }
    return std::nullopt;
}

std::optional<std::size_t> columnNumber(std::string_view text) {
    const auto number = parseId(text);
    if (!number || *number == 0 || text.find_first_not_of("0123456789") != std::string_view::npos) {
        return std::nullopt;
    }
    return static_cast<std::size_t>(*number - 1);
}

std::string list(const std::vector<std::string>& names) {
    std::string all;
    for (const std::string& name : names) {
        if (all.size() > 400) return all + ", ...";
        all += (all.empty() ? "" : ", ") + name;
    }
    return all;
}

}  // namespace

Result<TableMap> TableMap::parse(std::string_view text) {
    TableMap map;
    for (text = trim(text); !text.empty();) {
        const std::size_t end = entryEnd(text);
        const std::string_view entry = trim(text.substr(0, end));
        text = trim(text.substr(std::min(end + 1, text.size())));
        const std::size_t equals = entry.find('=');
        if (equals == std::string_view::npos || equals == 0 || equals + 1 == entry.size()) {
            return invalid("map", "'" + std::string(entry.substr(0, 80)) +
                                      "' is not QUANTITY=COLUMN [UNIT], as in \"x=X [mm],px=PX [MeV/c]\"");
        }
        const std::string quantity(trim(entry.substr(0, equals)));
        const auto meaning = tableMeaning(quantity, "map");
        if (!meaning || !meaning->has_value()) {
            return invalid("map", "'" + quantity.substr(0, 40) + "' is none of " + tableQuantityNames());
        }
        const auto [column, unit] = splitUnit(entry.substr(equals + 1));
        map.entries_.push_back({quantity, std::string(column), std::string(unit)});
        if (map.entries_.size() > maxEntries) return invalid("map", "has more than 64 entries");
    }
    return map;
}

bool TableMap::fits(const std::vector<std::string>& names) const {
    return std::all_of(entries_.begin(), entries_.end(), [&](const Entry& entry) {
        return columnNamed(names, entry.column) || parseNumber(entry.column);
    });
}

Status TableMap::apply(const std::vector<std::string>& names, std::vector<TableField>& fields,
                       std::vector<TableConstant>& constants) const {
    for (const Entry& entry : entries_) {
        auto column = columnNamed(names, entry.column);
        const auto number = columnNumber(entry.column);
        if (!column && number && *number < names.size()) column = number;
        if (column) {
            const std::string_view own = splitUnit(names[*column]).second;
            const std::string unit = entry.unit.empty() ? std::string(own) : entry.unit;
            fields.push_back({*column, entry.quantity + (unit.empty() ? "" : " " + unit)});
            continue;
        }
        const auto value = parseNumber(entry.column);
        if (!value || !std::isfinite(*value)) {
            return Error{
                ErrorCode::notFound, "map",
                "the table has no column '" + entry.column.substr(0, 80) + "'; it has " + list(names)};
        }
        const std::string name = entry.quantity + (entry.unit.empty() ? "" : " " + entry.unit);
        MOTE_ASSIGN_OR_RETURN(const auto meaning, tableMeaning(name, "map"));
        if (meaning->relative || meaning->inMass)
            return invalid("map", "a number cannot be in the unit " + entry.unit);
        constants.push_back({meaning->quantity, *value * meaning->factor});
    }
    return success();
}

}  // namespace mote::prep
