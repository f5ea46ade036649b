// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/plot_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "preprocess/job.h"
#include "preprocess/particles/lost_filter.h"
#include "preprocess/particles/particles_job.h"
#include "preprocess/particles/plot_axis.h"
#include "protocol/scene/step_range.h"
#include "storage/manifest.h"

namespace mote::prep {
namespace {

constexpr std::uint64_t megabyte = std::uint64_t{1} << 20;

namespace fs = std::filesystem;

/// Inputs as seen from the folder that holds the dataset; nothing else that depends on where or how it was
/// made.
proto::JobRequest portableRequest(const proto::JobRequest& request, const std::vector<fs::path>& inputs,
                                  const fs::path& output) {
    proto::JobRequest portable = request;
    portable.clear_output();
    auto& job = *portable.mutable_particles();
    job.clear_inputs();
    for (const auto& input : inputs) job.add_inputs(portableInput(input, output));
    return portable;
}

Status checkNumber(std::uint32_t value, std::uint32_t least, std::uint32_t greatest, const char* field) {
    if (value >= least && value <= greatest) return success();
    return invalid(field, fmt::format("must be {} to {}, not {}", least, greatest, value));
}

Status checkAxes(const proto::ParticlesJob& job) {
    if (job.axes_size() != 3)
        return invalid("axes", fmt::format("a plot has three axes, not {}", job.axes_size()));
    for (const auto& name : job.axes()) MOTE_RETURN_IF_ERROR(Quantity::checkForm(name), "axes");
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
        if (isOfSteps(bounds)) continue;
        if (!std::isfinite(bounds.max() - bounds.min()) || !(bounds.min() < bounds.max())) {
            return invalid(field, "bounds must be finite, the least below the greatest");
        }
    }
    return success();
}

}  // namespace

MemoryPlan planMemory(std::uint64_t particles, const StepOptions& options, std::uint64_t limit, int threads) {
    // Rounded up from measurements of 10^7 and 10^8 particles. Whatever their number: the program, the grid,
    // blocks on their way, the volume; then nodes and leaves, of which there are more the smaller the leaves,
    // on every rank.
    const std::uint64_t fixed = 96 * megabyte + static_cast<std::uint64_t>(threads) * 48 * megabyte;
    const std::uint64_t small = std::min(fixed, 4 * megabyte + 400 * particles);
    const std::uint64_t volume = std::uint64_t{12} << (3 * options.volumeLevel);
    const std::uint64_t tree = 300 * (particles / options.octree.leafCapacity + 1);
    const std::uint64_t preview = 32 * std::min<std::uint64_t>(particles / 4, storage::Preview::mostPoints);
    MemoryPlan plan;
    plan.needed = small + volume + tree + preview;
    const std::uint64_t all = memoryFor(limit);
    if (plan.needed > all) return plan;
    plan.kept = std::min(256 * megabyte, (all - plan.needed) / 8);
    plan.particles = all - plan.needed - plan.kept;
    return plan;
}

proto::Manifest describePlot(const PlotRequest& asked, const PlotAxes& axes, const PlotBounds& bounds,
                             const StepOptions& options) {
    proto::Manifest manifest;
    manifest.set_kind("particles");
    manifest.set_format(storage::formatVersion);
    manifest.set_writer("mote-prep " MOTE_VERSION);
    *manifest.mutable_request() = portableRequest(asked.request, asked.inputs, asked.output);
    manifest.set_title(asked.request.title());
    if (asked.request.title().empty() && !asked.inputs.empty()) {
        manifest.set_title(fmt::format("{}: {} {} {}", asked.inputs.front().filename().string(),
                                       axes[0].name(), axes[1].name(), axes[2].name()));
    }
    auto& particles = *manifest.mutable_particles();
    const auto add = [&](const std::array<Range, 3>& ranges) {
        for (std::size_t a = 0; a < 3; ++a) {
            auto& axis = *particles.add_axes();
            axis.set_name(axes[a].name());
            axis.set_unit(axes[a].unit());
            axis.set_min(ranges[a].min);
            axis.set_max(ranges[a].max);
        }
    };
    add(bounds.all());
    for (std::size_t step = 0; bounds.ofSteps() && step < bounds.steps(); ++step) add(bounds.of(step));
    particles.set_volume_level(options.volumeLevel);
    particles.set_leaf_capacity(options.octree.leafCapacity);
    particles.set_max_level(options.octree.maxLevel);
    return manifest;
}

Status checkParticlesJob(const proto::ParticlesJob& job) {
    if (job.inputs().empty()) return invalid("inputs", "there is no input");
    MOTE_RETURN_IF_ERROR(checkAxes(job));
    MOTE_RETURN_IF_ERROR(checkStepRange(job.steps()));
    MOTE_RETURN_IF_ERROR(checkBounds(job));
    MOTE_RETURN_IF_ERROR(parseLostParticles(job.lost()));
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
