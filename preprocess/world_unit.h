// SPDX-License-Identifier: GPL-3.0-or-later
//
// The unit of a length in the world of a volume or a mesh: what its file says, else what the request says,
// else, in a frame of patients, millimetres. Pure functions.
#pragma once

#include <fmt/format.h>

#include <string>

#include "preprocess/job.h"
#include "preprocess/volume/volume_shape.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
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

inline constexpr const char* millimetresAssumed =
    "the file does not say the unit of its lengths: in a frame of patients they are taken for mm";

/// Whether lengths are in mm though the file does not say so: all that write patients' frames write mm.
inline bool inUnsaidMillimetres(const VolumeShape& shape) {
    return shape.worldUnit.empty() && !shape.worldSpace.empty();
}

/// Of a volume, in whose frame of patients mm need not be said. Errors: as above.
inline Result<std::string> worldUnitFor(const proto::JobRequest& request, const VolumeShape& shape,
                                        Progress& progress) {
    if (!request.unit().empty() || !inUnsaidMillimetres(shape))
        return worldUnitFor(request, shape.worldUnit, progress);
    progress.note(millimetresAssumed);
    return std::string("mm");
}

}  // namespace mote::prep
