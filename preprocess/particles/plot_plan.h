// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a request for a plot comes to: the steps of a run that it takes ("FIRST:LAST:STRIDE" of the run's step
// indices, last included), the memory for each, and what the manifest says before any step is built. Pure
// functions, but for the machine's size and the names of the file system.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "preprocess/particles/bounds_rule.h"
#include "preprocess/particles/step_builder.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// The form alone. Also "N", "FIRST:LAST"; an empty FIRST is 0, an empty LAST the run's last step. Errors:
/// invalidArgument.
Status checkStepSelection(std::string_view text);

/// Indices in ascending order; all of them for "". Errors: as above, invalidArgument where FIRST or LAST is
/// not a step of the run.
Result<std::vector<std::size_t>> selectSteps(std::string_view text, std::size_t available);

struct MemoryPlan {
    std::uint64_t needed = 0;     ///< bytes without which the step cannot be built
    std::uint64_t particles = 0;  ///< bytes left for particles in memory
    std::uint64_t kept = 0;       ///< bytes left for what was read and will be needed again
};

/// The plan for a step of so many particles; `limit` is this process', 0 for three quarters of the machine's
/// memory. Figures measured: docs/JOBS.md.
MemoryPlan planMemory(std::uint64_t particles, const StepOptions& options, std::uint64_t limit, int threads);

struct PlotRequest {
    const proto::JobRequest& request;
    const std::vector<std::filesystem::path>& inputs;
    const std::filesystem::path& output;
};

proto::Manifest describePlot(const PlotRequest& asked, const PlotAxes& axes,
                             const std::array<Range, 3>& bounds, const StepOptions& options);

}  // namespace mote::prep
