// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/plot_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <span>

#include "preprocess/new_dataset.h"
#include "preprocess/particles/lost_filter.h"
#include "preprocess/particles/particles_job.h"
#include "preprocess/particles/plot_axis.h"
#include "preprocess/particles/range_builder.h"
#include "protocol/quantity/known_quantity.h"
#include "protocol/scene/fields/facts.h"
#include "protocol/scene/fields/resolve.h"
#include "protocol/scene/step_range.h"
#include "storage/manifest.h"

namespace mote::prep {
namespace {

Result<Range> widenedOf(const Range& found, const PlotAxis& axis) {
    auto range = widened(found);
    if (range.ok()) return range;
    return Error{range.error().code, fmt::format("axis {}", axis.name()), range.error().message};
}

constexpr std::string_view summedOver = ", summed over all steps";

constexpr std::uint64_t megabyte = std::uint64_t{1} << 20;

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

/// From so many times on the cells of a volume are too few for the beam.
constexpr double muchTravel = 8.0;

/// The quantity that is this one about its mean in the step; empty where there is none.
std::string ownFrameOf(std::string_view name) {
    if (name == "z") return "zeta";
    if (name == "t") return "tau";
    const auto own = fmt::format("{}_c", name);
    return findKnownQuantity(own) != nullptr ? own : std::string();
}

}  // namespace

Result<std::vector<std::uint64_t>> densityHistogram(const storage::StepFile& file, std::uint64_t begin,
                                                    std::uint64_t end, const Range& densities,
                                                    const Progress& progress) {
    constexpr std::uint64_t together = std::uint64_t{1} << 20;
    std::vector<std::uint64_t> bins(storage::densityHistogramBins);
    for (std::uint64_t leaf = begin; leaf < end; leaf += together) {
        if (progress.cancelled()) return wasCancelled();
        const auto count = static_cast<std::size_t>(std::min(together, end - leaf));
        std::vector<float> density(count);
        std::vector<std::uint32_t> points(count);
        MOTE_RETURN_IF_ERROR(file.read(storage::StepArray::leafDensity, leaf * sizeof(float),
                                       std::as_writable_bytes(std::span(density))));
        MOTE_RETURN_IF_ERROR(file.read(storage::StepArray::leafPointCount, leaf * sizeof(std::uint32_t),
                                       std::as_writable_bytes(std::span(points))));
        addToHistogram(density, points, {densities.min, densities.max}, bins);
    }
    return bins;
}

std::vector<std::string> leftOutNotes(const proto::ParticlesManifest& particles, bool boundsGiven,
                                      std::uint64_t others) {
    std::uint64_t lost = 0;
    std::uint64_t invalid = 0;
    std::uint64_t outside = 0;
    for (const auto& step : particles.steps()) {
        lost += step.lost();
        invalid += step.invalid();
        outside += step.outside();
    }
    std::vector<std::string> sentences;
    const auto note = [&](std::uint64_t count, const char* what) {
        if (count > 0) sentences.push_back(fmt::format("{} particles {}{}", count, what, summedOver));
    };
    note(lost, "that the source marks as lost were left out");
    note(others, "that the source does not mark as lost were left out");
    note(invalid, "with a coordinate or weight that is not a finite number were left out");
    note(outside,
         boundsGiven ? "beyond the given bounds were left out" : "beyond the plot's bounds were left out");
    return sentences;
}

bool isLeftOutNote(std::string_view sentence) {
    return sentence.ends_with(summedOver);
}

void PlotBounds::goOn(const proto::ParticlesManifest& plot) {
    for (int a = 0; a < 3; ++a)
        before_[static_cast<std::size_t>(a)] = {plot.axes(a).min(), plot.axes(a).max()};
}

Status PlotBounds::find(const proto::ParticlesJob& job, const PlotAxes& axes, std::size_t steps) {
    bounds_.resize(steps);
    for (std::size_t a = 0; a < 3; ++a) {
        const auto given = std::ranges::find(job.bounds(), axes[a].name(), &proto::Axis::name);
        const bool own = given == job.bounds().end() ? job.bounds_of() == "step" : isOfSteps(*given);
        if (given != job.bounds().end() && !own) {
            all_[a] = {given->min(), given->max()};
        } else {
            Range found = before_[a];
            for (const auto& step : steps_) found = found.united(step.ranges[a]);
            if (found.empty()) return notFound("", "");
            MOTE_ASSIGN_OR_RETURN(all_[a], widenedOf(found, axes[a]));
        }
        common_[a] = given == job.bounds().end() && !own;
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
    for (std::size_t a = 0; a < 3; ++a) {
        if (travel(a) < muchTravel) continue;
        const auto own = ownFrameOf(axes[a].name());
        sentences.push_back(fmt::format(
            "over all steps {0} spans more than {1:.0f} times what it spans in any one of them, so the beam "
            "is "
            "small in this plot; --bounds-of step follows it{2}",
            axes[a].name(), muchTravel, own.empty() ? "" : fmt::format(", and so does the axis {}", own)));
    }
    return sentences;
}

double PlotBounds::travel(std::size_t axis) const {
    double widest = 0.0;
    for (const auto& step : steps_) {
        const auto& range = step.ranges[axis];
        if (!range.empty()) widest = std::max(widest, range.max - range.min);
    }
    return common_[axis] && before_[axis].empty() && widest > 0.0 ? (all_[axis].max - all_[axis].min) / widest
                                                                  : 0.0;
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

void addAxes(const PlotAxes& axes, const std::array<Range, 3>& ranges,
             google::protobuf::RepeatedPtrField<proto::Axis>& to) {
    for (std::size_t a = 0; a < 3; ++a) {
        auto& axis = *to.Add();
        axis.set_name(axes[a].name());
        axis.set_unit(axes[a].unit());
        axis.set_min(ranges[a].min);
        axis.set_max(ranges[a].max);
    }
}

proto::Manifest describePlot(const PlotRequest& asked, const PlotAxes& axes, const PlotBounds& bounds,
                             const StepOptions& options) {
    std::string title;
    if (!asked.inputs.empty()) {
        title = fmt::format("{}: {} {} {}", asked.inputs.front().filename().string(), axes[0].name(),
                            axes[1].name(), axes[2].name());
    }
    auto manifest = beginManifest("particles", asked.request, title);
    auto& job = *manifest.mutable_request()->mutable_particles();
    job.clear_inputs();
    for (const auto& input : asked.inputs) job.add_inputs(portableInput(input, asked.output));
    auto& particles = *manifest.mutable_particles();
    addAxes(axes, bounds.all(), *particles.mutable_axes());
    particles.set_volume_level(options.volumeLevel);
    particles.set_leaf_capacity(options.octree.leafCapacity);
    particles.set_max_level(options.octree.maxLevel);
    return manifest;
}

StepOptions stepOptionsOf(const proto::ParticlesJob& job) {
    using Job = proto::ParticlesJob;
    const auto level = [&](int field) { return static_cast<std::uint32_t>(numberOf(job, field)); };
    return {{level(Job::kLeafCapacityFieldNumber), level(Job::kMaxLevelFieldNumber)},
            level(Job::kVolumeLevelFieldNumber)};
}

Status checkParticlesJob(const proto::ParticlesJob& job) {
    if (job.inputs().empty()) return invalid("inputs", "there is no input");
    MOTE_RETURN_IF_ERROR(checkAxes(job));
    MOTE_RETURN_IF_ERROR(checkStepRange(job.steps()));
    MOTE_RETURN_IF_ERROR(checkBounds(job));
    MOTE_RETURN_IF_ERROR(checkOwnFields(job));
    return success();
}

}  // namespace mote::prep
