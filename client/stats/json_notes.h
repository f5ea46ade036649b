// SPDX-License-Identifier: GPL-3.0-or-later
//
// What limits numbers, as a member of a line of JSON. A pure function.
#pragma once

#include <string>
#include <vector>

#include "protocol/scene/json_string.h"

namespace mote::client {

/// ', "notes": ["..."]', to be put behind a line's other members; "" where there are none.
inline std::string jsonNotes(const std::vector<std::string>& notes) {
    std::string list;
    for (const auto& note : notes) list += (list.empty() ? "" : ", ") + jsonString(note);
    return list.empty() ? list : ", \"notes\": [" + list + "]";
}

}  // namespace mote::client
