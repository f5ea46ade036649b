// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/particles_job.h"

#include <fmt/format.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <optional>

#include "preprocess/job.h"
#include "preprocess/on_threads.h"
#include "preprocess/parallel/communicator.h"
#include "preprocess/particles/column_output.h"
#include "preprocess/particles/dataset_source.h"
#include "preprocess/particles/job_columns.h"
#include "preprocess/particles/job_summary.h"
#include "preprocess/particles/lost_filter.h"
#include "preprocess/particles/noted_progress.h"
#include "preprocess/particles/plot_bounds.h"
#include "preprocess/particles/plot_plan.h"
#include "preprocess/particles/range_builder.h"
#include "preprocess/particles/step_builder.h"
#include "preprocess/particles/step_output.h"
#include "preprocess/particles/step_statistics.h"
#include "protocol/quantity/statistic.h"
#include "protocol/scene/step_range.h"
#include "storage/files/dataset_file.h"
#include "storage/manifest.h"
#include "storage/particles/mapped_columns.h"
#include "storage/particles/step_file.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t mostBytesPerParticle = 24;  // while a step is built, docs/JOBS.md

class Job {
  public:
    Job(const proto::JobRequest& request, ParticleSource& source, const std::vector<fs::path>& inputs,
        const fs::path& output, const JobResources& resources, NotedProgress& progress)
        : request_(request),
          job_(request.particles()),
          unfiltered_(source),
          lost_(lostParticlesOf(source, request.particles())),
          source_(source, lost_),
          inputs_(inputs),
          output_(output),
          resources_(resources),
          ranks_(*resources.ranks),
          progress_(progress) {}

    Result<proto::Manifest> run() {
        MOTE_RETURN_IF_ERROR(agree(ranks_, prepare()));
        MOTE_ASSIGN_OR_RETURN(auto dataset, SharedDataset::create(ranks_, output_));
        dataset_.emplace(std::move(dataset));
        MOTE_RETURN_IF_ERROR(findBounds());
        manifest_ = describePlot({request_, inputs_, output_}, axes_, plotBounds_, stepOptions_);
        MOTE_RETURN_IF_ERROR(makeSteps());
        MOTE_RETURN_IF_ERROR(makeColumns());
        MOTE_RETURN_IF_ERROR(agree(ranks_, writeback_.finish()));
        MOTE_RETURN_IF_ERROR(agree(ranks_, ranks_.first() ? finish() : success()));
        dataset_->finish();
        report(1.0, "done");
        return std::move(manifest_);
    }

  private:
    Status prepare() {
        MOTE_RETURN_IF_ERROR(checkParticlesJob(job_));
        for (int i = 0; i < 3; ++i) {
            MOTE_ASSIGN_OR_RETURN(auto axis, PlotAxis::make(job_.axes(i), source_));
            axes_[static_cast<std::size_t>(i)] = std::move(axis);
        }
        MOTE_ASSIGN_OR_RETURN(columns_, JobColumns::make(job_, unfiltered_));
        MOTE_ASSIGN_OR_RETURN(steps_, selectSteps(job_.steps(), source_.steps().size()));
        if (steps_.size() > static_cast<std::size_t>(storage::maxSteps)) {
            return Error{ErrorCode::resourceExhausted, "steps",
                         fmt::format("{} steps are more than the {} that one dataset holds; select some",
                                     steps_.size(), storage::maxSteps)};
        }
        stepOptions_.volumeLevel = job_.has_volume_level() ? job_.volume_level() : defaultVolumeLevel;
        stepOptions_.octree = {job_.has_leaf_capacity() ? job_.leaf_capacity() : defaultLeafCapacity,
                               job_.has_max_level() ? job_.max_level() : defaultMaxLevel};
        return checkMemory();
    }

    /// `together`: among how many steps the memory is divided.
    MemoryPlan memoryFor(std::size_t step, std::size_t together) const {
        return planMemory(source_.steps()[step].particles, stepOptions_,
                          prep::memoryFor(resources_.memory) / together,
                          tbb::this_task_arena::max_concurrency());
    }

    /// Whether two steps at once, one being built and one being written, fit into the memory without a
    /// temporary file. Ranks take steps one by one: their calls must meet in one order.
    bool roomForTwo() const {
        if (ranks_.size() > 1 || steps_.size() < 2 || tbb::this_task_arena::max_concurrency() < 2)
            return false;
        return std::all_of(steps_.begin(), steps_.end(), [&](std::size_t step) {
            return memoryFor(step, 2).particles >= mostBytesPerParticle * source_.steps()[step].particles;
        });
    }

    Status checkMemory() {
        together_ = roomForTwo() ? 2 : 1;
        mayKeep_ = std::numeric_limits<std::uint64_t>::max();
        for (const auto step : steps_) {
            const auto& info = source_.steps()[step];
            const auto plan = memoryFor(step, together_);
            mayKeep_ = std::min(mayKeep_, plan.kept);
            if (plan.particles > 0) continue;
            constexpr double gigabyte = 1e9;
            return Error{
                ErrorCode::resourceExhausted, info.file,
                fmt::format("step {} has {} particles, for which the job needs at least {:.2f} GB of "
                            "memory; the limit is {:.2f} GB. A larger leaf capacity needs less",
                            step, info.particles, static_cast<double>(plan.needed) / gigabyte * 1.02,
                            static_cast<double>(resources_.memory) / gigabyte)};
        }
        return success();
    }

    void report(double fraction, std::string_view phase) {
        if (!ranks_.first()) return;
        // A step is begun before the one before it is written.
        const std::lock_guard lock(reporting_);
        reported_ = std::max(reported_, fraction);
        progress_.report(reported_, phase);
    }

    Result<StepReader> openReader(std::size_t index) {
        return StepReader::open(source_, steps_[index], axes_, ranks_, progress_, mayKeep_);
    }

    bool boundsGiven() const {
        return job_.bounds_size() == 3 && std::ranges::none_of(job_.bounds(), isOfSteps);
    }

    Status findBounds() {
        readers_.resize(steps_.size());
        for (std::size_t i = 0; i < steps_.size() && !boundsGiven(); ++i) {
            report(0.2 * static_cast<double>(i) / static_cast<double>(steps_.size()),
                   fmt::format("looking for the bounds: step {} of {}", i + 1, steps_.size()));
            MOTE_ASSIGN_OR_RETURN(auto reader, openReader(i));
            MOTE_ASSIGN_OR_RETURN(const auto found, stepBounds(reader, ranks_));
            plotBounds_.add(found);
            mayKeep_ -= reader.keptBytes();
            readers_[i].emplace(std::move(reader));
        }
        const auto found = plotBounds_.find(job_, axes_, steps_.size());
        if (!found.ok() && found.error().code == ErrorCode::notFound) return nothingToPlot();
        return found;
    }

    Error nothingToPlot() const {
        return {
            ErrorCode::notFound, inputs_.empty() ? "" : inputs_.front().string(),
            "no selected step has a particle to plot: all are lost, not finite or outside the given bounds"};
    }

    void reportStep(std::size_t index, double part, std::string_view what) {
        const double done = (static_cast<double>(index) + part) / static_cast<double>(steps_.size());
        const double before = boundsGiven() ? 0.0 : 0.2;
        report(before + (0.8 - before) * done,
               fmt::format("{} step {} of {}", what, index + 1, steps_.size()));
    }

    Status makeSteps() {
        return inTwoStages(
            steps_.size(), together_, [&](std::size_t index) { return build(index); },
            [&](std::size_t index, BuiltStep built) { return take(index, built); });
    }

    Status take(std::size_t index, const BuiltStep& built) {
        const auto& info = source_.steps()[steps_[index]];
        auto& entry = *manifest_.mutable_particles()->add_steps();
        // Of lost particles alone none is left out that is lost.
        entry.set_lost(lost_ == LostParticles::without ? built.counts.lost : 0);
        othersLeftOut_ += lost_ == LostParticles::only ? built.counts.lost : 0;
        entry.set_invalid(built.counts.invalid);
        entry.set_outside(built.counts.outside);
        entry.set_particles(built.counts.particles);
        entry.set_iteration(info.iteration);
        entry.set_time(std::isfinite(info.time) ? info.time : 0.0);
        entry.set_total_weight(built.octree.totalWeight);
        densities_ = densities_.united(densityRange(built.octree));
        leaves_.push_back(built.octree.leafNode.size());
        reportStep(index, 0.6, "writing");
        return write(built, static_cast<std::uint32_t>(index), entry);
    }

    Result<BuiltStep> build(std::size_t index) {
        reportStep(index, 0.0, "building");
        auto built = buildFrom(index);
        readers_[index].reset();
        if (built.ok() || !built.error().where.empty()) return built;
        return Error{built.error().code, source_.steps()[steps_[index]].file, built.error().message,
                     built.error().passing};
    }

    Result<BuiltStep> buildFrom(std::size_t index) {
        if (!readers_[index]) {
            MOTE_ASSIGN_OR_RETURN(auto reader, openReader(index));
            readers_[index].emplace(std::move(reader));
        }
        const StepResources resources{&ranks_, [this] { return progress_.cancelled(); },
                                      memoryFor(steps_[index], together_).particles, dataset_->directory()};
        return buildStep(*readers_[index], plotBounds_.of(index), stepOptions_, resources);
    }

    Status write(const BuiltStep& built, std::uint32_t index, proto::ParticleStepEntry& entry) {
        StepOutput output;
        output.directory = dataset_->directory();
        output.name = storage::stepName(index);
        entry.set_file(output.name + ".h5");
        entry.set_digest(output.name + ".digest");
        for (std::size_t a = 0; a < 3; ++a) {
            output.attributes.axes[a] = axes_[a].name();
            output.attributes.boundsMin[a] = plotBounds_.of(index)[a].min;
            output.attributes.boundsMax[a] = plotBounds_.of(index)[a].max;
        }
        output.attributes.totalWeight = built.octree.totalWeight;
        output.ranks = &ranks_;
        output.cancelled = [this] { return progress_.cancelled(); };
        output.complete = [&] { return takeFile(entry.file()); };
        MOTE_ASSIGN_OR_RETURN(const auto places, writeBuiltStep(built, output));
        places_.push_back(places);
        return ranks_.first() ? dataset_->writer().add(entry.digest(), output.cancelled) : success();
    }

    /// Beside the points of every step, when all of them stand: then the memory is free for columns.
    Status makeColumns() {
        auto& particles = *manifest_.mutable_particles();
        columns_.describe(source_, particles);
        if (lost_ != LostParticles::without) {
            particles.set_lost_particles(lost_ == LostParticles::with ? "with" : "only");
        }
        for (const auto& statistic : mote::statistics()) {
            particles.add_statistic_names(statistic.name);
        }
        for (std::size_t i = 0; i < steps_.size(); ++i) {
            const double each = 0.17 / static_cast<double>(steps_.size());
            report(0.8 + each * static_cast<double>(i),
                   fmt::format("statistics of step {} of {}", i + 1, steps_.size()));
            auto& entry = *particles.mutable_steps(static_cast<int>(i));
            MOTE_ASSIGN_OR_RETURN(const auto points,
                                  storage::StepFile::open(dataset_->directory() / entry.file(), places_[i]));
            auto sampled =
                ColumnSample::make(points, entry.particles(), columns_.sources(), lost_, progress_);
            MOTE_RETURN_IF_ERROR(agree(ranks_, sampled.ok() ? success() : Status(sampled.error())));
            MOTE_ASSIGN_OR_RETURN(const auto statistics, findStatistics(i, *sampled));
            entry.mutable_statistics()->Assign(statistics.begin(), statistics.end());
            if (columns_.empty()) continue;
            MOTE_RETURN_IF_ERROR(sampled->share(ranks_));
            report(0.8 + each * (static_cast<double>(i) + 0.5),
                   fmt::format("writing the columns of step {} of {}", i + 1, steps_.size()));
            MOTE_RETURN_IF_ERROR(makeColumns(i, points, *sampled, particles));
        }
        for (auto& column : *particles.mutable_columns()) {
            if (column.min() > column.max()) column.set_max(0.0);  // no finite value in any step
        }
        return success();
    }

    Result<std::vector<double>> findStatistics(std::size_t index, ColumnSample& sample) {
        auto records = columns_.sources();
        std::erase_if(records, [](Column column) { return !isRecord(column); });
        return stepStatistics({&unfiltered_, steps_[index], lost_, prep::memoryFor(resources_.memory),
                               &ranks_, &progress_, std::move(records),
                               [&](const ParticleChunk& chunk) { sample.take(chunk); }});
    }

    Status makeColumns(std::size_t index, const storage::StepFile& points, const ColumnSample& sample,
                       proto::ParticlesManifest& particles) {
        auto& entry = *particles.mutable_steps(static_cast<int>(index));
        ColumnsRequest request;
        request.source = &unfiltered_;
        request.step = steps_[index];
        request.context = contextOf(source_);
        setMeans(
            [&](std::string_view name) { return entry.statistics(static_cast<int>(*findStatistic(name))); },
            request.context);
        request.directory = dataset_->directory();
        request.name = storage::columnsName(static_cast<std::uint32_t>(index));
        request.points = &points;
        request.sample = &sample;
        request.pointCount = entry.particles();
        request.memory = prep::memoryFor(resources_.memory);
        request.ranks = &ranks_;
        request.writeback = &writeback_;
        request.progress = &progress_;
        MOTE_RETURN_IF_ERROR(columns_.write(request, particles, entry));
        if (!ranks_.first()) return success();
        MOTE_RETURN_IF_ERROR(takeFile(entry.columns_file()));
        return dataset_->writer().add(entry.columns_digest(), [this] { return progress_.cancelled(); });
    }

    /// Hashes the file; the disk gets it meanwhile, so that publishing need not wait.
    Status takeFile(const std::string& name) {
        writeback_.begin(dataset_->directory() / name);
        return dataset_->writer().add(name, [this] { return progress_.cancelled(); });
    }

    /// What is known only after the last step: the scale of densities, and with it each step's histogram,
    /// from the files just written.
    Status finish() {
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
        for (std::size_t i = 0; i < places_.size(); ++i) {
            auto& entry = *particles.mutable_steps(static_cast<int>(i));
            MOTE_ASSIGN_OR_RETURN(const auto file,
                                  storage::StepFile::open(dataset_->directory() / entry.file(), places_[i]));
            MOTE_ASSIGN_OR_RETURN(const auto bins, densityHistogram(file, leaves_[i], densities_, progress_));
            entry.mutable_density_histogram()->Assign(bins.begin(), bins.end());
        }
        noteLeftOut(particles, boundsGiven(), othersLeftOut_, progress_);
        for (const auto& sentence : plotBounds_.notes(axes_)) progress_.note(sentence);
        particles.mutable_notes()->Assign(progress_.notes().begin(), progress_.notes().end());
        if (progress_.cancelled()) return cancelledError();
        MOTE_RETURN_IF_ERROR(dataset_->writer().publish(manifest_));
        manifest_.mutable_files()->Assign(dataset_->writer().files().begin(),
                                          dataset_->writer().files().end());
        return success();
    }

    const proto::JobRequest& request_;
    const proto::ParticlesJob& job_;
    ParticleSource& unfiltered_;
    LostParticles lost_;
    LostFilter source_;
    const std::vector<fs::path>& inputs_;
    fs::path output_;
    JobResources resources_;
    Communicator& ranks_;
    NotedProgress& progress_;
    std::mutex reporting_;
    double reported_ = 0.0;  ///< under it

    PlotAxes axes_;
    JobColumns columns_;
    std::vector<std::size_t> steps_;  ///< of the source
    StepOptions stepOptions_;
    std::size_t together_ = 1;                        ///< steps that are under way at once
    std::uint64_t mayKeep_ = 0;                       ///< bytes of what is read, for its next use
    std::vector<std::optional<StepReader>> readers_;  ///< by selected step, from the pass over the bounds
    std::optional<SharedDataset> dataset_;            ///< while it is made
    storage::Writeback writeback_;                    ///< of its files
    std::vector<storage::StepFile::Places> places_;   ///< by selected step
    std::vector<std::uint64_t> leaves_;               ///< by selected step
    PlotBounds plotBounds_;
    Range densities_;
    std::uint64_t othersLeftOut_ = 0;  ///< particles that are not lost, of a plot of those that are
    proto::Manifest manifest_;
};

Result<proto::Manifest> runNoted(const proto::JobRequest& request, ParticleSource& source,
                                 const std::vector<fs::path>& inputs, const fs::path& output,
                                 const JobResources& resources, NotedProgress& progress) {
    const auto alone = singleProcess();
    JobResources all = resources;
    if (!all.ranks) all.ranks = alone.get();
    return onThreads(resources.threads,
                     [&] { return Job(request, source, inputs, output, all, progress).run(); });
}

}  // namespace

Result<proto::Manifest> runParticlesJob(const proto::JobRequest& request, ParticleSource& source,
                                        const std::vector<fs::path>& inputs, const fs::path& output,
                                        const JobResources& resources, Progress& progress) {
    NotedProgress noted(progress);
    return runNoted(request, source, inputs, output, resources, noted);
}

Result<proto::Manifest> runParticlesJob(const proto::JobRequest& request, const std::vector<fs::path>& inputs,
                                        const fs::path& output, const JobResources& resources,
                                        Progress& progress) {
    MOTE_RETURN_IF_ERROR(checkParticlesJob(request.particles()));
    NotedProgress noted(progress);
    auto source = isDataset(inputs) ? openDataset(request.particles(), inputs.front())
                                    : openParticleSource(request.particles(), inputs, noted);
    const Status opened = source.ok() ? success() : Status(source.error());
    MOTE_RETURN_IF_ERROR(resources.ranks ? agree(*resources.ranks, opened) : opened);
    return runNoted(request, **source, inputs, output, resources, noted);
}

}  // namespace mote::prep
