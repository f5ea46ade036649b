// SPDX-License-Identifier: GPL-3.0-or-later
//
// StepWays: how the particles that two steps of a run both have go from one to the other (docs/PICTURE.md,
// "Between steps"), found by their ids. A value; stepWays() as the functions of point_data.h.
#pragma once

#include <cstdint>
#include <memory>

#include "protocol/base/error.h"
#include "server/render/layers/particles/point_data.h"
#include "server/render/plan/point_ways.h"
#include "storage/numbers/run_steps.h"

namespace mote::render {

struct StepWays {
    PointWays there, back;     ///< of the points of the first step, and of those of the second
    std::uint64_t moving = 0;  ///< that both have; 0 also if
    bool swung = false;        ///< they swing so far that nobody knows how they went

    std::uint64_t bytes() const;
    /// That are held while they are found, at most, for each point of either step.
    static constexpr std::uint64_t bytesAPoint =
        sizeof(glm::vec3) + sizeof(PointWays::Bend) + sizeof(std::uint32_t) + sizeof(glm::vec3);
};

/// An id that several points of one step have tells none of them. Errors: notFound (the dataset has no ids);
/// cancelled.
Result<std::shared_ptr<const StepWays>> stepWays(const storage::RunSteps& run, std::uint32_t first,
                                                 std::uint32_t second, const Cancelled& cancelled);

}  // namespace mote::render
