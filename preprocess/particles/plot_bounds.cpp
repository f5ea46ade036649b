// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/plot_bounds.h"

#include <fmt/format.h>

#include <algorithm>

namespace mote::prep {

void PlotBounds::add(const StepBounds& step) {
    for (std::size_t a = 0; a < 3; ++a) {
        found_[a] = found_[a].united(step.ranges[a]);
        cuts_[a].add(step.cuts[a]);
    }
}

Result<std::array<Range, 3>> PlotBounds::find(const proto::ParticlesJob& job, const PlotAxes& axes) const {
    std::array<Range, 3> bounds;
    for (std::size_t a = 0; a < 3; ++a) {
        const auto given = std::ranges::find(job.bounds(), std::string(axes[a].name), &proto::Axis::name);
        if (given != job.bounds().end()) {
            bounds[a] = {given->min(), given->max()};
            continue;
        }
        if (found_[a].empty()) return Error{ErrorCode::notFound, "", ""};
        const auto range = widened(found_[a]);
        if (!range.ok()) {
            return Error{range.error().code, fmt::format("axis {}", axes[a].name), range.error().message};
        }
        bounds[a] = *range;
    }
    return bounds;
}

std::vector<std::string> PlotBounds::notes(const std::array<Range, 3>& bounds, const PlotAxes& axes) const {
    std::vector<std::string> sentences;
    for (std::size_t a = 0; a < 3; ++a) {
        const auto& [particles, values] = cuts_[a];
        if (particles == 0 || (bounds[a].contains(values.min) && bounds[a].contains(values.max))) continue;
        const Range all = values.united(bounds[a]);
        sentences.push_back(
            fmt::format("{} {} at {} {} lie by themselves, ten times further from the others' median than "
                        "all others, and "
                        "are left out; --bounds {}={}:{} keeps them",
                        particles, particles == 1 ? "value" : "values", axes[a].name,
                        values.min == values.max ? fmt::format("{:.6g}", values.min)
                                                 : fmt::format("{:.6g} to {:.6g}", values.min, values.max),
                        axes[a].name, all.min, all.max));
    }
    return sentences;
}

}  // namespace mote::prep
