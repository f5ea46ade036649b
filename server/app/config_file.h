// SPDX-License-Identifier: GPL-3.0-or-later
//
// The file of --config: TOML, whose keys are the names of options. Pure, but for reading it.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "protocol/base/error.h"

namespace mote::server {

/// What stands in the file under one key.
struct ConfigValue {
    std::vector<std::string> values;  ///< as texts, for ServerOption::set
    std::string where;                ///< "server.toml:3"
};

/// By the option's name. Errors: notFound; invalidArgument with file and line: no TOML, a key that is no
/// option (with the nearest that is one), a value of another type.
Result<std::map<std::string, ConfigValue>> readConfig(const std::string& path);

}  // namespace mote::server
