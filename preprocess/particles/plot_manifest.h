// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the manifest of a plot says before any of its steps is built. A pure function, but for the names of
// the file system.
#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "preprocess/particles/bounds_rule.h"
#include "preprocess/particles/step_builder.h"
#include "protocol/mote.pb.h"

namespace mote::prep {

struct PlotRequest {
    const proto::JobRequest& request;
    const std::vector<std::filesystem::path>& inputs;
    const std::filesystem::path& output;
};

proto::Manifest describePlot(const PlotRequest& asked, const PlotAxes& axes,
                             const std::array<Range, 3>& bounds, const StepOptions& options);

}  // namespace mote::prep
