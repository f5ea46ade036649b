// SPDX-License-Identifier: GPL-3.0-or-later
//
// SddsCommand: one command of an SDDS header, "&column name=x, units=m, &end", as names and values. A value;
// one thread.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "protocol/base/error.h"

namespace mote::prep {

struct SddsCommand {
    std::string name;  ///< without its '&'
    std::vector<std::pair<std::string, std::string>> fields;

    /// Nothing where the field is not there.
    const std::string* find(std::string_view field) const;

    /// A whole command, "&end" included. Error, at `where`: corrupt.
    static Result<SddsCommand> parse(std::string_view text, const std::string& where);
};

/// `line` without a comment: from a '!' outside of quotes on.
std::string_view withoutSddsComment(std::string_view line);

/// Bytes of the command that `text` begins with, up to and with its "&end" outside of quotes; nothing where
/// it has no end yet.
std::optional<std::size_t> sddsCommandEnd(std::string_view text);

}  // namespace mote::prep
