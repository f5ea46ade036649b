// SPDX-License-Identifier: GPL-3.0-or-later
//
// The unit of a length in the world of a volume or a mesh: what its file says, else what the request says.
// A pure function.
#pragma once

#include <fmt/format.h>

#include <string>

#include "preprocess/job.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "protocol/scene/space/length_unit.h"

namespace mote::prep {

/// `said`: by the file; "": nothing. What it says and what is no length that is known, as "pixels", gives way
/// to the request's, with a note. Errors: invalidArgument, at "unit": the file says another length.
inline Result<std::string> worldUnitFor(const proto::JobRequest& request, const std::string& said,
                                        Progress& progress) {
    const auto& asked = request.unit();
    if (asked.empty() || said.empty()) return asked.empty() ? said : asked;
    const auto known = metresOf(said);
    if (known && known == metresOf(asked)) return asked;
    if (known)
        return invalid("unit",
                       fmt::format("the file says that its lengths are in {}, not {}: leave the unit out",
                                   ownName(said), asked));
    progress.note(fmt::format(
        "the file's lengths are in \"{}\", which is no known unit: they are taken for {}", said, asked));
    return asked;
}

}  // namespace mote::prep
