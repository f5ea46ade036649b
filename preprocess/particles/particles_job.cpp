// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/particles_job.h"

#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "preprocess/particles/density_histogram.h"
#include "preprocess/particles/step_builder.h"
#include "preprocess/particles/step_selection.h"
#include "storage/dataset_writer.h"
#include "storage/manifest.h"
#include "storage/particles/mapped_step.h"
#include "storage/particles/step_writer.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

/// Particles of earlier steps that are kept between the pass over the bounds and the building: bytes.
constexpr std::uint64_t cacheLimit = std::uint64_t{512} << 20;

Error cancelledError() {
    return {ErrorCode::cancelled, "", "cancelled"};
}

/// Inputs as seen from the folder that holds the dataset; nothing else that depends on where or how it was
/// made.
proto::JobRequest portableRequest(const proto::JobRequest& request, const std::vector<fs::path>& inputs,
                                  const fs::path& output) {
    proto::JobRequest portable = request;
    portable.clear_output();
    auto& job = *portable.mutable_particles();
    job.clear_inputs();
    std::error_code code;
    const auto folder = fs::weakly_canonical(fs::absolute(output, code).parent_path(), code);
    for (const auto& input : inputs) {
        job.add_inputs(
            fs::weakly_canonical(fs::absolute(input, code), code).lexically_relative(folder).string());
    }
    return portable;
}

class Job {
  public:
    Job(const proto::JobRequest& request, ParticleSource& source, const std::vector<fs::path>& inputs,
        const fs::path& output, const ParticlesJobOptions& options, Progress& progress)
        : request_(request),
          job_(request.particles()),
          source_(source),
          inputs_(inputs),
          output_(output),
          options_(options),
          progress_(progress) {}

    Result<proto::Manifest> run() {
        MOTE_RETURN_IF_ERROR(prepare());
        auto writer = storage::DatasetWriter::create(output_);
        if (!writer.ok()) return writer.error();
        MOTE_RETURN_IF_ERROR(findBounds());
        describe();
        for (std::size_t i = 0; i < steps_.size(); ++i) MOTE_RETURN_IF_ERROR(makeStep(i, *writer));
        MOTE_RETURN_IF_ERROR(finish(*writer));
        if (progress_.cancelled()) return cancelledError();
        MOTE_RETURN_IF_ERROR(writer->publish(manifest_));
        manifest_.mutable_files()->Assign(writer->files().begin(), writer->files().end());
        progress_.report(1.0, "done");
        return std::move(manifest_);
    }

  private:
    Status prepare() {
        MOTE_RETURN_IF_ERROR(checkParticlesJob(job_));
        for (int i = 0; i < 3; ++i) {
            auto axis = findAxis(job_.axes(i));
            if (!axis.ok()) return axis.error();
            MOTE_RETURN_IF_ERROR(checkAxis(*axis, source_));
            axes_[static_cast<std::size_t>(i)] = *std::move(axis);
        }
        auto steps = selectSteps(job_.steps(), source_.steps().size());
        if (!steps.ok()) return steps.error();
        steps_ = *std::move(steps);
        if (steps_.size() > static_cast<std::size_t>(storage::maxSteps)) {
            return Error{ErrorCode::resourceExhausted, "steps",
                         fmt::format("{} steps are more than the {} that one dataset holds; select some",
                                     steps_.size(), storage::maxSteps)};
        }
        stepOptions_.volumeLevel = job_.has_volume_level() ? job_.volume_level() : defaultVolumeLevel;
        stepOptions_.octree = {job_.has_leaf_capacity() ? job_.leaf_capacity() : defaultLeafCapacity,
                               job_.has_max_level() ? job_.max_level() : defaultMaxLevel};
        kept_.resize(steps_.size());
        return checkMemory();
    }

    Status checkMemory() const {
        for (const auto step : steps_) {
            const auto& info = source_.steps()[step];
            const auto needed = buildMemory(info.particles, stepOptions_);
            if (options_.memory == 0 || needed <= options_.memory) continue;
            constexpr double gigabyte = 1e9;
            return Error{
                ErrorCode::resourceExhausted, info.file,
                fmt::format("step {} has {} particles, which take {:.1f} GB of memory; the limit is {:.1f} "
                            "GB",
                            step, info.particles, static_cast<double>(needed) / gigabyte,
                            static_cast<double>(options_.memory) / gigabyte)};
        }
        return success();
    }

    std::uint64_t mayKeep() const {
        if (options_.memory == 0) return cacheLimit;
        std::uint64_t largest = 0;
        for (const auto step : steps_) {
            largest = std::max(largest, buildMemory(source_.steps()[step].particles, stepOptions_));
        }
        return std::min(cacheLimit, options_.memory - largest);
    }

    bool boundsGiven() const { return job_.bounds_size() == 3; }

    Status findBounds() {
        std::array<Range, 3> found;
        std::uint64_t keptBytes = 0;
        for (std::size_t i = 0; i < steps_.size() && !boundsGiven(); ++i) {
            progress_.report(0.3 * static_cast<double>(i) / static_cast<double>(steps_.size()),
                             fmt::format("looking for the bounds: step {} of {}", i + 1, steps_.size()));
            auto particles = loadStep(source_, steps_[i], axes_, progress_);
            if (!particles.ok()) return particles.error();
            for (std::size_t a = 0; a < 3; ++a) {
                found[a] = found[a].united(robustRange(particles->coordinate[a]));
            }
            keptBytes += particles->bytes();
            if (steps_.size() == 1 || keptBytes <= mayKeep()) kept_[i] = *std::move(particles);
        }
        for (std::size_t a = 0; a < 3; ++a) MOTE_RETURN_IF_ERROR(setBounds(a, found[a]));
        return success();
    }

    Status setBounds(std::size_t axis, const Range& found) {
        for (const auto& given : job_.bounds()) {
            if (given.name() != axes_[axis].name) continue;
            bounds_[axis] = {given.min(), given.max()};
            return success();
        }
        if (found.empty()) return nothingToPlot();
        const auto range = widened(found);
        if (!range.ok()) {
            return Error{range.error().code, fmt::format("axis {}", axes_[axis].name), range.error().message};
        }
        bounds_[axis] = *range;
        return success();
    }

    Error nothingToPlot() const {
        return {
            ErrorCode::notFound, inputs_.empty() ? "" : inputs_.front().string(),
            "no selected step has a particle to plot: all are lost, not finite or outside the given bounds"};
    }

    void describe() {
        manifest_.set_kind("particles");
        manifest_.set_format(storage::formatVersion);
        manifest_.set_writer("mote-prep " MOTE_VERSION);
        *manifest_.mutable_request() = portableRequest(request_, inputs_, output_);
        manifest_.set_title(request_.title());
        if (request_.title().empty() && !inputs_.empty()) {
            manifest_.set_title(fmt::format("{}: {} {} {}", inputs_.front().filename().string(),
                                            axes_[0].name, axes_[1].name, axes_[2].name));
        }
        auto& particles = *manifest_.mutable_particles();
        for (std::size_t a = 0; a < 3; ++a) {
            auto& axis = *particles.add_axes();
            axis.set_name(std::string(axes_[a].name));
            axis.set_unit(std::string(axes_[a].unit));
            axis.set_min(bounds_[a].min);
            axis.set_max(bounds_[a].max);
        }
        particles.set_volume_level(stepOptions_.volumeLevel);
        particles.set_leaf_capacity(stepOptions_.octree.leafCapacity);
        particles.set_max_level(stepOptions_.octree.maxLevel);
    }

    Result<StepParticles> take(std::size_t index) {
        if (!kept_[index]) return loadStep(source_, steps_[index], axes_, progress_);
        StepParticles particles = *std::move(kept_[index]);
        kept_[index].reset();
        return particles;
    }

    void reportStep(std::size_t index, double part, std::string_view what) {
        const double done = (static_cast<double>(index) + part) / static_cast<double>(steps_.size());
        const double before = boundsGiven() ? 0.0 : 0.3;
        progress_.report(before + (0.97 - before) * done,
                         fmt::format("{} step {} of {}", what, index + 1, steps_.size()));
    }

    Status makeStep(std::size_t index, storage::DatasetWriter& writer) {
        reportStep(index, 0.0, "reading");
        auto particles = take(index);
        if (!particles.ok()) return particles.error();
        auto& entry = *manifest_.mutable_particles()->add_steps();
        entry.set_lost(particles->lost);
        entry.set_invalid(particles->invalid);
        reportStep(index, 0.3, "building");
        auto quantized = quantize(*std::move(particles), bounds_);
        entry.set_outside(quantized.outside);
        entry.set_particles(quantized.size());
        const auto& info = source_.steps()[steps_[index]];
        auto built = buildStep(std::move(quantized), stepOptions_, [this] { return progress_.cancelled(); });
        if (!built.ok()) return Error{built.error().code, info.file, built.error().message};
        entry.set_iteration(info.iteration);
        entry.set_time(std::isfinite(info.time) ? info.time : 0.0);
        entry.set_total_weight(built->octree.totalWeight);
        densities_ = densities_.united(densityRange(built->octree.leaves()));
        reportStep(index, 0.8, "writing");
        return write(*built, static_cast<std::uint32_t>(index), entry, writer);
    }

    Status write(const BuiltStep& built, std::uint32_t index, proto::ParticleStepEntry& entry,
                 storage::DatasetWriter& writer) {
        auto content = built.content();
        for (std::size_t a = 0; a < 3; ++a) {
            content.axes[a] = axes_[a].name;
            content.boundsMin[a] = bounds_[a].min;
            content.boundsMax[a] = bounds_[a].max;
        }
        const auto name = storage::stepName(index);
        entry.set_file(name + ".h5");
        entry.set_digest(name + ".digest");
        MOTE_RETURN_IF_ERROR(storage::writeStep(writer.directory(), name, content));
        const auto cancelled = [this] { return progress_.cancelled(); };
        MOTE_RETURN_IF_ERROR(writer.add(entry.file(), cancelled));
        return writer.add(entry.digest(), cancelled);
    }

    /// What is known only after the last step: the scale of densities, and with it each step's histogram,
    /// from the files just written.
    Status finish(storage::DatasetWriter& writer) {
        auto& particles = *manifest_.mutable_particles();
        std::uint64_t total = 0;
        for (const auto& step : particles.steps()) total += step.particles();
        if (total == 0) return nothingToPlot();
        if (densities_.empty()) {
            return Error{ErrorCode::corrupt, inputs_.empty() ? "" : inputs_.front().string(),
                         "all particles weigh nothing, so there is no density to plot"};
        }
        particles.set_density_min(densities_.min);
        particles.set_density_max(densities_.max);
        manifest_.mutable_files()->Assign(writer.files().begin(), writer.files().end());
        for (int i = 0; i < particles.steps_size(); ++i) {
            if (progress_.cancelled()) return cancelledError();
            const auto step =
                storage::MappedStep::open(writer.directory(), manifest_, static_cast<std::uint32_t>(i));
            if (!step.ok()) return step.error();
            const auto histogram = densityHistogram((*step)->leaves(), (*step)->logDensity());
            particles.mutable_steps(i)->mutable_density_histogram()->Assign(histogram.begin(),
                                                                            histogram.end());
        }
        noteLeftOut();
        return success();
    }

    void noteLeftOut() {
        std::uint64_t lost = 0;
        std::uint64_t invalid = 0;
        std::uint64_t outside = 0;
        for (const auto& step : manifest_.particles().steps()) {
            lost += step.lost();
            invalid += step.invalid();
            outside += step.outside();
        }
        const auto note = [&](std::uint64_t count, const char* what) {
            if (count > 0) progress_.note(fmt::format("{} particles {}, summed over all steps", count, what));
        };
        note(lost, "that the source marks as lost were left out");
        note(invalid, "with a coordinate or weight that is not a finite number were left out");
        note(outside, boundsGiven() ? "beyond the given bounds were left out"
                                    : "beyond the bounds (further than 1000 interquartile ranges from the "
                                      "median, or beyond given bounds) were left out");
    }

    const proto::JobRequest& request_;
    const proto::ParticlesJob& job_;
    ParticleSource& source_;
    const std::vector<fs::path>& inputs_;
    fs::path output_;
    ParticlesJobOptions options_;
    Progress& progress_;

    PlotAxes axes_;
    std::vector<std::size_t> steps_;  ///< of the source
    StepOptions stepOptions_;
    std::vector<std::optional<StepParticles>> kept_;  ///< by selected step, from the pass over the bounds
    std::array<Range, 3> bounds_;
    Range densities_;
    proto::Manifest manifest_;
};

}  // namespace

Result<proto::Manifest> runParticlesJob(const proto::JobRequest& request, ParticleSource& source,
                                        const std::vector<fs::path>& inputs, const fs::path& output,
                                        const ParticlesJobOptions& options, Progress& progress) {
    const int threads = options.threads > 0 ? options.threads : tbb::task_arena::automatic;
    std::optional<tbb::global_control> more;
    // More threads than cores only where asked for: the library stops at the cores otherwise.
    if (options.threads > 0) {
        more.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(options.threads));
    }
    tbb::task_arena arena(threads);
    return arena.execute([&] { return Job(request, source, inputs, output, options, progress).run(); });
}

}  // namespace mote::prep
