// SPDX-License-Identifier: GPL-3.0-or-later
//
// VolumeParts: several volumes in one file (times, frames), or several values for each voxel (components,
// channels), and which of them is read. Values and pure functions.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/scene/error.h"

namespace mote::prep {

struct VolumeParts {
    std::uint64_t volumes = 1;                ///< one after the other
    std::uint64_t components = 1;             ///< of a voxel, one beside the other
    std::uint64_t volume = 0, component = 0;  ///< those that are read, from 0

    std::uint64_t count() const { return volumes * components; }
};

/// `parts` with what `field` asks for: "3", the volume of that number (of a file with one volume, the
/// component), ":2", a component, "3:2" both. Errors, at `where`: unsupported (there are several and none was
/// asked for: a sentence that lists them), notFound (no such number), invalidArgument (`field` is no number),
/// resourceExhausted (more than can be counted).
Result<VolumeParts> chooseParts(std::string_view field, VolumeParts parts, const std::string& where);

/// The fields of all volumes, where `field` leaves open which; else `field` alone.
std::vector<std::string> fieldsOfSeries(const std::string& field, const VolumeParts& parts);

}  // namespace mote::prep
