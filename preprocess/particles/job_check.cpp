// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cmath>
#include <set>

#include "preprocess/particles/particles_job.h"
#include "preprocess/particles/plot_axis.h"
#include "preprocess/particles/step_selection.h"
#include "storage/manifest.h"

namespace mote::prep {
namespace {

Error invalid(std::string field, std::string message) {
    return {ErrorCode::invalidArgument, std::move(field), std::move(message)};
}

Status checkNumber(std::uint32_t value, std::uint32_t least, std::uint32_t greatest, const char* field) {
    if (value >= least && value <= greatest) return success();
    return invalid(field, fmt::format("must be {} to {}, not {}", least, greatest, value));
}

Status checkAxes(const proto::ParticlesJob& job) {
    if (job.axes_size() != 3)
        return invalid("axes", fmt::format("a plot has three axes, not {}", job.axes_size()));
    for (const auto& name : job.axes()) MOTE_RETURN_IF_ERROR(findAxis(name));
    if (std::set<std::string>(job.axes().begin(), job.axes().end()).size() != 3) {
        return invalid("axes", "the three axes must differ");
    }
    return success();
}

Status checkBounds(const proto::ParticlesJob& job) {
    std::set<std::string_view> seen;
    for (int i = 0; i < job.bounds_size(); ++i) {
        const auto& bounds = job.bounds(i);
        const auto field = fmt::format("bounds[{}]", i);
        if (std::find(job.axes().begin(), job.axes().end(), bounds.name()) == job.axes().end()) {
            return invalid(field,
                           fmt::format("\"{}\" is none of the plot's axes", bounds.name().substr(0, 40)));
        }
        if (!seen.insert(bounds.name()).second) return invalid(field, "gives an axis' bounds twice");
        if (!std::isfinite(bounds.max() - bounds.min()) || !(bounds.min() < bounds.max())) {
            return invalid(field, "bounds must be finite, the least below the greatest");
        }
    }
    return success();
}

}  // namespace

Status checkParticlesJob(const proto::ParticlesJob& job) {
    if (job.inputs().empty()) return invalid("inputs", "there is no input");
    MOTE_RETURN_IF_ERROR(checkAxes(job));
    MOTE_RETURN_IF_ERROR(checkStepSelection(job.steps()));
    MOTE_RETURN_IF_ERROR(checkBounds(job));
    if (job.has_volume_level()) {
        MOTE_RETURN_IF_ERROR(checkNumber(job.volume_level(), 1, storage::maxVolumeLevel, "volumeLevel"));
    }
    if (job.has_leaf_capacity()) {
        MOTE_RETURN_IF_ERROR(checkNumber(job.leaf_capacity(), 1, 1U << 30, "leafCapacity"));
    }
    if (job.has_max_level()) {
        MOTE_RETURN_IF_ERROR(checkNumber(job.max_level(), 0, storage::maxOctreeLevel, "maxLevel"));
    }
    return success();
}

}  // namespace mote::prep
