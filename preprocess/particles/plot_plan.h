// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a request for a plot comes to: the memory for each step, and what the manifest says before any step is
// built. Pure functions, but for the machine's size and the names of the file system.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "preprocess/particles/bounds_rule.h"
#include "preprocess/particles/plot_bounds.h"
#include "preprocess/particles/step_builder.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::prep {

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

proto::Manifest describePlot(const PlotRequest& asked, const PlotAxes& axes, const PlotBounds& bounds,
                             const StepOptions& options);

}  // namespace mote::prep
