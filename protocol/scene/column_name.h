// SPDX-License-Identifier: GPL-3.0-or-later
//
// The name of a column or derived quantity as a message gives it. A pure function; whether there is such a
// column, the dataset knows.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

#include "protocol/scene/error.h"

namespace mote {

/// Errors: invalidArgument at the field: empty, longer than 64 bytes, or with a control character.
inline Result<std::string> checkColumnName(const std::string& name, std::string_view field) {
    constexpr std::size_t longest = 64;
    const auto invalid = [&](std::string message) {
        return Error{ErrorCode::invalidArgument, std::string(field), std::move(message)};
    };
    if (name.empty()) return invalid("the name of a column is missing");
    if (name.size() > longest) return invalid(fmt::format("is longer than {} bytes", longest));
    for (const unsigned char c : name) {
        if (c < 0x20 || c == 0x7f) return invalid("holds a control character");
    }
    return name;
}

}  // namespace mote
