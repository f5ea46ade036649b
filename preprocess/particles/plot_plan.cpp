// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/plot_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <set>
#include <string>

#include "preprocess/job.h"
#include "preprocess/particles/particles_job.h"
#include "preprocess/particles/plot_axis.h"
#include "storage/manifest.h"

namespace mote::prep {
namespace {

struct Selection {
    std::size_t first = 0;
    std::optional<std::size_t> last;
    std::size_t stride = 1;
};

Error invalid(std::string message) {
    return {ErrorCode::invalidArgument, "steps", std::move(message)};
}

std::optional<std::size_t> parseNumber(std::string_view text) {
    std::size_t number = 0;
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (code != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return number;
}

Result<Selection> parse(std::string_view text) {
    const Error wrong =
        invalid(fmt::format("\"{}\" is not FIRST:LAST:STRIDE of step indices", text.substr(0, 60)));
    std::vector<std::optional<std::size_t>> numbers;
    std::string_view rest = text;
    while (true) {
        const auto colon = rest.find(':');
        const auto part = rest.substr(0, colon);
        numbers.push_back(parseNumber(part));
        if ((!part.empty() && !numbers.back()) || numbers.size() > 3) return wrong;
        if (colon == std::string_view::npos) break;
        rest.remove_prefix(colon + 1);
    }
    Selection selection{numbers[0].value_or(0), std::nullopt, 1};
    if (numbers.size() == 1) {
        if (!numbers[0]) return wrong;
        selection.last = numbers[0];
    } else {
        selection.last = numbers[1];
    }
    if (numbers.size() == 3) selection.stride = numbers[2].value_or(1);
    if (selection.stride == 0) return invalid("the stride must be at least 1");
    if (selection.last && *selection.last < selection.first)
        return invalid("the last step lies before the first");
    return selection;
}

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

Status checkStepSelection(std::string_view text) {
    if (text.empty()) return success();
    const auto parsed = parse(text);
    return parsed.ok() ? success() : Status(parsed.error());
}

Result<std::vector<std::size_t>> selectSteps(std::string_view text, std::size_t available) {
    Selection selection;
    if (!text.empty()) {
        MOTE_ASSIGN_OR_RETURN(selection, parse(text));
    }
    if (available == 0) return Error{ErrorCode::notFound, "steps", "the run has no steps"};
    const std::size_t last = selection.last.value_or(available - 1);
    if (last >= available || selection.first >= available) {
        return invalid(fmt::format("{} reaches beyond the run's {} step{}, 0 to {}", text, available,
                                   available == 1 ? "" : "s", available - 1));
    }
    std::vector<std::size_t> steps;
    for (std::size_t step = selection.first; step <= last; step += selection.stride) {
        steps.push_back(step);
        if (selection.stride > last - step) break;
    }
    return steps;
}

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

proto::Manifest describePlot(const PlotRequest& asked, const PlotAxes& axes,
                             const std::array<Range, 3>& bounds, const StepOptions& options) {
    proto::Manifest manifest;
    manifest.set_kind("particles");
    manifest.set_format(storage::formatVersion);
    manifest.set_writer("mote-prep " MOTE_VERSION);
    *manifest.mutable_request() = portableRequest(asked.request, asked.inputs, asked.output);
    manifest.set_title(asked.request.title());
    if (asked.request.title().empty() && !asked.inputs.empty()) {
        manifest.set_title(fmt::format("{}: {} {} {}", asked.inputs.front().filename().string(), axes[0].name,
                                       axes[1].name, axes[2].name));
    }
    auto& particles = *manifest.mutable_particles();
    for (std::size_t a = 0; a < 3; ++a) {
        auto& axis = *particles.add_axes();
        axis.set_name(std::string(axes[a].name));
        axis.set_unit(std::string(axes[a].unit));
        axis.set_min(bounds[a].min);
        axis.set_max(bounds[a].max);
    }
    particles.set_volume_level(options.volumeLevel);
    particles.set_leaf_capacity(options.octree.leafCapacity);
    particles.set_max_level(options.octree.maxLevel);
    return manifest;
}

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
