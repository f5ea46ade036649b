// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/plot_bounds.h"

#include <fmt/format.h>

#include <algorithm>

namespace mote::prep {

namespace {

Result<Range> widenedOf(const Range& found, const PlotAxis& axis) {
    const auto range = widened(found);
    if (range.ok()) return range;
    return Error{range.error().code, fmt::format("axis {}", axis.name()), range.error().message};
}

}  // namespace

Status PlotBounds::find(const proto::ParticlesJob& job, const PlotAxes& axes, std::size_t steps) {
    bounds_.resize(steps);
    for (std::size_t a = 0; a < 3; ++a) {
        const auto given = std::ranges::find(job.bounds(), axes[a].name(), &proto::Axis::name);
        const bool own = given != job.bounds().end() && isOfSteps(*given);
        if (given != job.bounds().end() && !own) {
            all_[a] = {given->min(), given->max()};
        } else {
            Range found;
            for (const auto& step : steps_) found = found.united(step.ranges[a]);
            if (found.empty()) return Error{ErrorCode::notFound, "", ""};
            MOTE_ASSIGN_OR_RETURN(all_[a], widenedOf(found, axes[a]));
        }
        for (std::size_t step = 0; step < steps; ++step) {
            bounds_[step][a] = all_[a];
            // A step without a particle has no range.
            if (!own || steps_[step].ranges[a].empty()) continue;
            MOTE_ASSIGN_OR_RETURN(bounds_[step][a], widenedOf(steps_[step].ranges[a], axes[a]));
        }
        ofSteps_ = ofSteps_ || own;
    }
    return success();
}

std::vector<std::string> PlotBounds::notes(const PlotAxes& axes) const {
    std::vector<std::string> sentences;
    for (std::size_t a = 0; a < 3; ++a) {
        Cut cut;
        for (const auto& step : steps_) cut.add(step.cuts[a]);
        const auto& [particles, values] = cut;
        if (particles == 0 || (all_[a].contains(values.min) && all_[a].contains(values.max))) continue;
        const Range all = values.united(all_[a]);
        sentences.push_back(
            fmt::format("{} {} at {} {} lie by themselves, ten times further from the others' median than "
                        "all others, and "
                        "are left out; --bounds {}={}:{} keeps them",
                        particles, particles == 1 ? "value" : "values", axes[a].name(),
                        values.min == values.max ? fmt::format("{:.6g}", values.min)
                                                 : fmt::format("{:.6g} to {:.6g}", values.min, values.max),
                        axes[a].name(), all.min, all.max));
    }
    return sentences;
}

}  // namespace mote::prep
