// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/particles_job.h"

#include <fmt/format.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "preprocess/kept_notes.h"
#include "preprocess/new_dataset.h"
#include "preprocess/on_threads.h"
#include "preprocess/parallel/communicator.h"
#include "preprocess/particles/column_output.h"
#include "preprocess/particles/lost_filter.h"
#include "preprocess/particles/plot_axis.h"
#include "preprocess/particles/plot_plan.h"
#include "preprocess/particles/range_builder.h"
#include "preprocess/particles/step_builder.h"
#include "preprocess/particles/step_statistics.h"
#include "protocol/quantity/statistic.h"
#include "protocol/scene/step_range.h"
#include "storage/beam/beam_statistics.h"
#include "storage/files/dataset_file.h"
#include "storage/manifest.h"
#include "storage/particles/mapped_columns.h"
#include "storage/particles/particle_columns.h"
#include "storage/particles/step_file.h"
#include "storage/storage_error.h"

namespace mote::prep {
namespace {

class DatasetSource final : public ParticleSource {
  public:
    DatasetSource(std::filesystem::path directory, proto::Manifest manifest)
        : directory_(std::move(directory)), manifest_(std::move(manifest)) {
        for (const auto& step : particles().steps()) {
            steps_.push_back({(directory_.filename() / step.file()).string(), step.iteration(), step.time(),
                              step.particles()});
        }
        for (const auto& column : particles().columns()) {
            const bool own = column.name() != "lost" && findKnownQuantity(column.name()) == nullptr;
            if (own && records_.size() < mostRecords)
                records_.push_back({column.name(), column.unit(), true});  // asked for once
        }
    }

    std::string format() const override { return "mote"; }
    const std::vector<SourceStep>& steps() const override { return steps_; }
    double mass() const override { return particles().mass(); }
    std::string species() const override { return particles().species(); }
    double particleCharge() const override { return particles().particle_charge(); }
    std::string weightUnit() const override { return particles().weight_unit(); }
    std::string lostParticles() const override { return particles().lost_particles(); }

    bool has(Column column) const override {
        return column == Column::id ? particles().ids() : indexOf(column).has_value();
    }

    std::vector<SourceRecord> records() const override { return records_; }

    std::vector<double> statistics(std::size_t step) const override {
        const auto names = mote::statistics();
        const auto same = [](const Statistic& a, const std::string& b) { return a.name == b; };
        if (!std::ranges::equal(names, particles().statistic_names(), same)) return {};
        const auto& values = particles().steps(static_cast<int>(step)).statistics();
        return {values.begin(), values.end()};
    }

    bool readsAtOnce(std::size_t) const override { return true; }

    Status read(std::size_t step, std::uint64_t begin, std::size_t count, const std::vector<Column>& wanted,
                ParticleChunk& chunk) override {
        MOTE_ASSIGN_OR_RETURN(const auto columns, opened(step));
        try {
            readOpen(*columns, begin, count, wanted, chunk);
            columns->check();
        } catch (const storage::StorageError& error) {
            return error.error();
        }
        return success();
    }

  private:
    const proto::ParticlesManifest& particles() const { return manifest_.particles(); }

    std::optional<std::size_t> indexOf(Column column) const {
        const auto& all = particles().columns();
        const auto found = std::ranges::find(all, columnName(column, *this), &proto::ColumnEntry::name);
        if (found == all.end()) return std::nullopt;
        return static_cast<std::size_t>(found - all.begin());
    }

    Result<std::shared_ptr<const storage::ParticleColumns>> opened(std::size_t step) {
        const std::lock_guard lock(opening_);
        if (open_ && openStep_ == step) return open_;
        MOTE_ASSIGN_OR_RETURN(
            open_, storage::ParticleColumns::open(directory_, manifest_, static_cast<std::uint32_t>(step)));
        openStep_ = step;
        return open_;
    }

    void readOpen(const storage::ParticleColumns& columns, std::uint64_t begin, std::size_t count,
                  const std::vector<Column>& wanted, ParticleChunk& chunk) const {
        chunk.begin = begin;
        chunk.size = count;
        chunk.lost.clear();
        // A dataset of lost particles alone says so of each.
        if (particles().lost_particles() == "only") chunk.lost.assign(count, 1);
        if (particles().lost_particles() == "with") readLost(columns, begin, count, chunk);
        for (const auto column : wanted) {
            if (column == Column::id) {
                const auto ids = columns.ids(begin, count);
                chunk.id.assign(ids.begin(), ids.end());
                continue;
            }
            auto& to = chunk[column];
            to.resize(count);
            if (const auto index = indexOf(column)) {
                columns.read(*index, begin, to);
            } else {
                std::ranges::fill(to, 1.0);  // missing weights
            }
        }
    }

    static void readLost(const storage::ParticleColumns& columns, std::uint64_t begin, std::size_t count,
                         ParticleChunk& chunk) {
        const auto column = columns.find("lost");
        std::vector<double> marks(column ? count : 0);
        if (column) columns.read(*column, begin, marks);
        for (const double mark : marks) chunk.lost.push_back(mark != 0.0 ? 1 : 0);
    }

    std::filesystem::path directory_;
    proto::Manifest manifest_;
    std::vector<SourceStep> steps_;
    std::vector<SourceRecord> records_;
    std::mutex opening_;  ///< of the two below
    std::size_t openStep_ = 0;
    std::shared_ptr<const storage::ParticleColumns> open_;
};

/// Whether inputs of a job name a dataset.
bool isDataset(const std::vector<std::filesystem::path>& inputs) {
    std::error_code code;
    return inputs.size() == 1 && std::filesystem::is_regular_file(inputs[0] / storage::manifestName, code);
}

/// Errors: notFound (no columns: says how to make them), invalidArgument (a choice of lost particles, a
/// species or a format that the dataset does not have), as storage::readManifest.
Result<std::unique_ptr<ParticleSource>> openDataset(const proto::ParticlesJob& job,
                                                    const std::filesystem::path& directory) {
    const auto name = directory.filename().string();
    if (!job.species().empty()) return invalid("species", "only openPMD files have species");
    if (!job.format().empty() && job.format() != "auto") {
        return invalid("format", fmt::format("{} is a dataset of Mote; leave the format out", name));
    }
    MOTE_ASSIGN_OR_RETURN(auto manifest, storage::readManifest(directory));
    if (!manifest.has_particles()) {
        return unsupported(name, "is a dataset without particles");
    }
    const auto& particles = manifest.particles();
    if (particles.columns().empty()) {
        return notFound(
            name,
            "has no columns to plot again; make it anew with mote-prep particles, from the files that "
            "it was made from, without --columns none");
    }
    const std::string has = particles.lost_particles().empty() ? "without" : particles.lost_particles();
    if (!job.lost().empty() && job.lost() != has) {
        return invalid("lost", fmt::format("{} was made {} lost particles, which cannot be changed from its "
                                           "columns; name the files that it was made from",
                                           name, has == "only" ? "of only" : has));
    }
    return std::unique_ptr<ParticleSource>(std::make_unique<DatasetSource>(directory, std::move(manifest)));
}

namespace fs = std::filesystem;

/// The request with bounds on the axes that have those of the whole run: those of the dataset that goes on.
proto::ParticlesJob withBoundsOf(const proto::ParticlesJob& job, const proto::Manifest& base) {
    auto bounded = job;
    for (const auto& axis : base.particles().axes()) {
        const bool given = std::ranges::count(job.bounds(), axis.name(), &proto::Axis::name) > 0;
        if (!given && job.bounds_of() != "step") *bounded.add_bounds() = axis;
    }
    for (auto& axis : *bounded.mutable_bounds())
        if (!isOfSteps(axis)) axis.clear_unit();
    return bounded;
}

constexpr std::uint64_t mostBytesPerParticle = 24;  // while a step is built, docs/JOBS.md

class Job {
  public:
    /// `live`: null, or what the steps are to a live dataset.
    Job(const proto::JobRequest& request, ParticleSource& source, const std::vector<fs::path>& inputs,
        const fs::path& output, const LiveSteps* live, const JobResources& resources, KeptNotes& progress)
        : request_(request),
          job_(request.particles()),
          unfiltered_(source),
          lost_(lostParticlesOf(source, request.particles())),
          source_(source, lost_),
          inputs_(inputs),
          output_(output),
          live_(live),
          base_(live != nullptr && live->base ? &*live->base : nullptr),
          first_(base_ != nullptr ? base_->particles().steps_size() : 0),
          resources_(resources),
          ranks_(*resources.ranks),
          progress_(progress) {}

    Result<proto::Manifest> run() {
        MOTE_RETURN_IF_ERROR(agree(ranks_, prepare()));
        MOTE_ASSIGN_OR_RETURN(auto dataset, SharedDataset::create(ranks_, output_));
        dataset_.emplace(std::move(dataset));
        MOTE_RETURN_IF_ERROR(findBounds());
        manifest_ = base_ != nullptr
                        ? *base_
                        : describePlot({request_, inputs_, output_}, axes_, plotBounds_, stepOptions_);
        describeGrowth();
        MOTE_RETURN_IF_ERROR(makeSteps());
        MOTE_RETURN_IF_ERROR(makeColumns());
        report(0.97, "waiting for the disk");
        MOTE_RETURN_IF_ERROR(agree(ranks_, writeback_.finish()));
        MOTE_RETURN_IF_ERROR(checkParticles());
        MOTE_RETURN_IF_ERROR(countDensities());
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
        MOTE_ASSIGN_OR_RETURN(columns_,
                              keptColumns(columnNames(), unfiltered_, lost_ == LostParticles::with));
        if (live_ != nullptr && live_->steps) {
            steps_ = *live_->steps;
        } else {
            MOTE_ASSIGN_OR_RETURN(steps_, selectSteps(job_.steps(), source_.steps().size()));
        }
        if (first_ + steps_.size() > static_cast<std::size_t>(storage::maxSteps)) {
            return Error{ErrorCode::resourceExhausted, "steps",
                         fmt::format("{} steps are more than the {} that one dataset holds; select some",
                                     first_ + steps_.size(), storage::maxSteps)};
        }
        bounded_ = base_ != nullptr ? withBoundsOf(job_, *base_) : job_;
        if (base_ != nullptr) MOTE_RETURN_IF_ERROR(checkSameRun());
        stepOptions_ = stepOptionsOf(job_);
        return checkMemory();
    }

    /// What is kept beside the points of further steps is what is kept of those before.
    google::protobuf::RepeatedPtrField<std::string> columnNames() const {
        if (base_ == nullptr || base_->particles().columns().empty()) return job_.columns();
        google::protobuf::RepeatedPtrField<std::string> names;
        for (const auto& column : base_->particles().columns()) {
            if (lost_ != LostParticles::with || column.name() != "lost") *names.Add() = column.name();
        }
        if (base_->particles().ids()) *names.Add() = "id";
        return names;
    }

    Status checkSameRun() const {
        proto::ParticlesManifest found;
        columns_.describe(source_, found);
        const auto& before = base_->particles();
        if (found.mass() != before.mass()) {
            return invalid("mass", fmt::format("is {:.10g} eV/c^2, and that of the live dataset {:.10g}: its "
                                               "steps are of one run",
                                               found.mass(), before.mass()));
        }
        if (found.species() == before.species() && found.weight_unit() == before.weight_unit() &&
            found.particle_charge() == before.particle_charge())
            return success();
        return invalid("inputs",
                       "hold other particles than the live dataset, by their species, charge or weight");
    }

    /// What further steps change of a live dataset's manifest, but for the steps themselves.
    void describeGrowth() {
        if (live_ == nullptr) return;
        auto& particles = *manifest_.mutable_particles();
        particles.set_live(live_->live);
        if (base_ == nullptr) return;
        particles.clear_axes();
        addAxes(axes_, plotBounds_.all(), *particles.mutable_axes());
    }

    int ofDataset(std::size_t index) const { return static_cast<int>(first_ + index); }

    /// Bytes that the source keeps of a step.
    std::uint64_t keptBySource(std::size_t step) const {
        return source_.keptBytes(step, static_cast<std::size_t>(tbb::this_task_arena::max_concurrency()));
    }
    /// What is left of the memory beside these.
    std::uint64_t memoryBeside(std::size_t step) const {
        const auto all = prep::memoryFor(resources_.memory);
        return all - std::min(all - 1, keptBySource(step));
    }

    /// `together`: among how many steps the memory is divided.
    MemoryPlan memoryFor(std::size_t step, std::size_t together) const {
        auto plan = planMemory(source_.steps()[step].particles, stepOptions_,
                               std::max<std::uint64_t>(memoryBeside(step) / together, 1),
                               tbb::this_task_arena::max_concurrency());
        plan.needed += keptBySource(step);
        return plan;
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

    static bool allGiven(const proto::ParticlesJob& job) {
        return job.bounds_size() == 3 && std::ranges::none_of(job.bounds(), isOfSteps);
    }
    /// So that no step is looked through for them.
    bool boundsGiven() const { return allGiven(bounded_); }

    Status findBounds() {
        readers_.resize(steps_.size());
        if (base_ != nullptr) plotBounds_.goOn(base_->particles());
        for (std::size_t i = 0; i < steps_.size() && !boundsGiven(); ++i) {
            report(0.2 * static_cast<double>(i) / static_cast<double>(steps_.size()),
                   fmt::format("looking for the bounds: step {} of {}", i + 1, steps_.size()));
            MOTE_ASSIGN_OR_RETURN(auto reader, openReader(i));
            MOTE_ASSIGN_OR_RETURN(const auto found, stepBounds(reader, ranks_));
            plotBounds_.add(found);
            mayKeep_ -= reader.keptBytes();
            readers_[i].emplace(std::move(reader));
        }
        auto found = plotBounds_.find(bounded_, axes_, steps_.size());
        if (!found.ok() && found.error().code == ErrorCode::notFound) return nothingToPlot();
        return found;
    }

    Error nothingToPlot() const {
        return notFound(
            inputs_.empty() ? "" : inputs_.front().string(),
            "no selected step has a particle to plot: all are lost, not finite or outside the given bounds");
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

    Status take(std::size_t index, BuiltStep& built) {
        const auto& info = source_.steps()[steps_[index]];
        auto& entry = *manifest_.mutable_particles()->add_steps();
        if (plotBounds_.ofSteps()) addAxes(axes_, plotBounds_.of(index), *entry.mutable_axes());
        // Of lost particles alone none is left out that is lost.
        entry.set_lost(lost_ == LostParticles::without ? built.counts.lost : 0);
        othersLeftOut_ += lost_ == LostParticles::only ? built.counts.lost : 0;
        entry.set_invalid(built.counts.invalid);
        entry.set_outside(built.counts.outside);
        entry.set_particles(built.counts.particles);
        entry.set_iteration(live_ != nullptr && live_->firstIteration
                                ? *live_->firstIteration + static_cast<std::int64_t>(index)
                                : info.iteration);
        entry.set_time(std::isfinite(info.time) ? info.time : 0.0);
        entry.set_total_weight(built.octree.totalWeight);
        densities_ = densities_.united(built.octree.toldDensities);
        leaves_.push_back(built.octree.leafTotal);
        reportStep(index, 0.6, "writing");
        return write(built, index, entry);
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
                                      memoryFor(steps_[index], together_).particles, stores_,
                                      dataset_->directory()};
        return buildStep(*readers_[index], plotBounds_.of(index), stepOptions_, resources);
    }

    Status write(BuiltStep& built, std::size_t index, proto::ParticleStepEntry& entry) {
        StepOutput output;
        output.directory = dataset_->directory();
        output.name = storage::stepName(static_cast<std::uint32_t>(ofDataset(index)));
        entry.set_file(output.name + ".h5");
        entry.set_digest(output.name + ".digest");
        for (std::size_t a = 0; a < 3; ++a) {
            output.attributes.axes[a] = axes_[a].name();
            output.attributes.boundsMin[a] = plotBounds_.of(index)[a].min;
            output.attributes.boundsMax[a] = plotBounds_.of(index)[a].max;
        }
        output.attributes.totalWeight = built.octree.totalWeight;
        MOTE_RETURN_IF_ERROR(makeHeldRows(index, built.counts.particles));
        output.rows = heldRows(built.counts.particles);
        output.rowsAreRead = !columns_.empty();
        output.ranks = &ranks_;
        output.cancelled = [this] { return progress_.cancelled(); };
        output.stores = stores_;
        // The disk gets the file while it is hashed, so that publishing need not wait.
        output.written = [&] { writeback_.begin(dataset_->directory() / entry.file()); };
        output.complete = [&](auto hash) { dataset_->writer().add(entry.file(), std::move(hash)); };
        MOTE_ASSIGN_OR_RETURN(const auto places, writeBuiltStep(built, output));
        places_.push_back(places);
        return ranks_.first() ? dataset_->writer().add(entry.digest(), output.cancelled) : success();
    }

    /// Where a single step's rows fit beside its particles they are not read again for its columns, nor for
    /// their hash, and the cache need not have them.
    Status makeHeldRows(std::size_t index, std::uint64_t points) {
        const std::uint64_t bytes = points * sizeof(std::uint32_t);
        if (steps_.size() > 1 || ranks_.size() > 1) return success();
        if (memoryFor(steps_[index], together_).particles < mostBytesPerParticle * points + bytes)
            return success();
        MOTE_ASSIGN_OR_RETURN(rows_, RecordStore::inMemory(bytes, stores_));
        rowBytes_ = bytes;
        return success();
    }

    std::span<std::uint32_t> heldRows(std::uint64_t points) {
        return rowBytes_ == 0 ? std::span<std::uint32_t>() : rows_.room<std::uint32_t>(0, points);
    }

    /// Beside the points of every step, when all of them stand: then the memory is free for columns.
    Status makeColumns() {
        auto& particles = *manifest_.mutable_particles();
        if (base_ == nullptr) describeColumns(particles);
        for (std::size_t i = 0; i < steps_.size(); ++i) {
            const double each = 0.17 / static_cast<double>(steps_.size());
            report(0.8 + each * static_cast<double>(i),
                   fmt::format("statistics of step {} of {}", i + 1, steps_.size()));
            auto& entry = *particles.mutable_steps(ofDataset(i));
            MOTE_ASSIGN_OR_RETURN(auto points,
                                  storage::StepFile::open(dataset_->directory() / entry.file(), places_[i]));
            if (rowBytes_ > 0) points.holdRows(heldRows(entry.particles()));
            // No column, nothing to choose a coding for.
            const std::uint64_t among = columns_.columns.empty() ? 0 : entry.particles();
            auto sampled = ColumnSample::make(points, among, columns_.sources(), lost_, progress_);
            MOTE_RETURN_IF_ERROR(agree(ranks_, sampled));
            StepStatistics statistics(statisticsRequest(i, *sampled));
            MOTE_RETURN_IF_ERROR(statistics.begin());
            entry.mutable_statistics()->Assign(statistics.values().begin(), statistics.values().end());
            const auto finish = [&]() -> Status {
                MOTE_RETURN_IF_ERROR(statistics.finish());
                entry.mutable_statistics()->Assign(statistics.values().begin(), statistics.values().end());
                return success();
            };
            if (columns_.empty()) {
                MOTE_RETURN_IF_ERROR(finish());
                continue;
            }
            MOTE_RETURN_IF_ERROR(sampled->share(ranks_));
            report(0.8 + each * (static_cast<double>(i) + 0.5),
                   fmt::format("writing the columns of step {} of {}", i + 1, steps_.size()));
            const auto meanwhile = [&]() -> Status {
                MOTE_RETURN_IF_ERROR(finish());
                const bool last = i + 1 == steps_.size() && ranks_.size() == 1;
                return last && !densities_.empty() ? countDensities() : success();
            };
            MOTE_RETURN_IF_ERROR(makeColumns(i, points, *sampled, meanwhile, particles));
        }
        for (auto& column : *particles.mutable_columns()) {
            if (column.min() > column.max()) column.set_max(0.0);  // no finite value in any step
        }
        return success();
    }

    void describeColumns(proto::ParticlesManifest& particles) const {
        columns_.describe(source_, particles);
        if (lost_ != LostParticles::without) {
            particles.set_lost_particles(lost_ == LostParticles::with ? "with" : "only");
        }
        for (const auto& statistic : mote::statistics()) {
            particles.add_statistic_names(statistic.name);
        }
    }

    StatisticsRequest statisticsRequest(std::size_t index, ColumnSample& sample) {
        const auto memory = memoryBeside(steps_[index]);
        // Without columns nothing is coded by what is seen.
        const auto observe = columns_.columns.empty()
                                 ? std::function<void(const ParticleChunk&)>()
                                 : [&](const ParticleChunk& chunk) { sample.take(chunk); };
        return {&unfiltered_, steps_[index],      lost_,  memory - std::min(memory, stores_->kept()), &ranks_,
                &progress_,   columns_.sources(), observe};
    }

    /// `meanwhile`: as that of ColumnsRequest.
    Status makeColumns(std::size_t index, const storage::StepFile& points, const ColumnSample& sample,
                       const std::function<Status()>& meanwhile, proto::ParticlesManifest& particles) {
        auto& entry = *particles.mutable_steps(ofDataset(index));
        ColumnsRequest request;
        request.kept = &columns_;
        request.source = &unfiltered_;
        request.step = steps_[index];
        request.context = contextOf(source_);
        setMeans(
            [&](std::string_view name) { return entry.statistics(static_cast<int>(*findStatistic(name))); },
            request.context);
        request.directory = dataset_->directory();
        request.name = storage::columnsName(static_cast<std::uint32_t>(ofDataset(index)));
        request.points = &points;
        request.sample = &sample;
        request.pointCount = entry.particles();
        const auto memory = memoryBeside(request.step);
        request.memory = memory - std::min(memory, rowBytes_);
        request.heldRows = heldRows(entry.particles());
        request.stores = stores_;
        request.ranks = &ranks_;
        request.writeback = &writeback_;
        request.progress = &progress_;
        request.meanwhile = meanwhile;
        MOTE_ASSIGN_OR_RETURN(const auto written, writeColumns(request));
        describeColumns(request.name, written, particles, entry);
        if (!ranks_.first()) return success();
        dataset_->writer().add(entry.columns_file(), written.hash);
        return dataset_->writer().add(entry.columns_digest(), [this] { return progress_.cancelled(); });
    }

    /// Fills the step's entry and widens the columns' ranges.
    static void describeColumns(const std::string& name, const WrittenColumns& written,
                                proto::ParticlesManifest& manifest, proto::ParticleStepEntry& entry) {
        entry.set_columns_file(name + ".h5");
        entry.set_columns_digest(name + ".digest");
        entry.mutable_column_resolution()->Assign(written.resolutions.begin(), written.resolutions.end());
        for (std::size_t i = 0; i < written.codings.size(); ++i) {
            auto& column = *manifest.mutable_columns(static_cast<int>(i));
            entry.add_column_offset(written.codings[i].offset);
            if (written.codings[i].doubles) column.set_type("f64");
            const auto range =
                Range{column.min(), column.max()}.united({written.least[i], written.greatest[i]});
            column.set_min(range.min);
            column.set_max(range.max);
        }
    }

    /// Whether there is something to plot; the same on all ranks.
    Status checkParticles() const {
        std::uint64_t total = 0;
        for (const auto& step : manifest_.particles().steps()) total += step.particles();
        if (total == 0) return nothingToPlot();
        if (base_ == nullptr && densities_.empty()) {
            return corrupt(inputs_.empty() ? "" : inputs_.front().string(),
                           "all particles weigh nothing, so there is no density to plot");
        }
        return success();
    }

    Status finish() {
        if (baseIsOld_) MOTE_RETURN_IF_ERROR(countBaseAnew());
        keepNotes(*manifest_.mutable_particles());
        return publishDataset(dataset_->writer(), manifest_, progress_);
    }

    /// What is known only when all steps stand: the scale of densities, and with it each step's histogram,
    /// from the files just written, some leaves by each rank. Once; all ranks call it.
    Status countDensities() {
        if (densitiesCounted_) return success();
        auto& particles = *manifest_.mutable_particles();
        const Range before{particles.density_min(), particles.density_max()};
        if (base_ != nullptr) densities_ = densities_.united(before);
        particles.set_density_min(densities_.min);
        particles.set_density_max(densities_.max);
        baseIsOld_ = base_ != nullptr && !(before == densities_);
        const auto mine = countLeaves();
        MOTE_RETURN_IF_ERROR(agree(ranks_, mine));
        MOTE_ASSIGN_OR_RETURN(const auto all, shareValues<std::uint64_t>(ranks_, *mine));
        constexpr std::size_t bins = storage::densityHistogramBins;
        for (std::size_t i = 0; i < places_.size(); ++i) {
            auto& histogram = *particles.mutable_steps(ofDataset(i))->mutable_density_histogram();
            histogram.Resize(bins, 0);
            for (const auto& ofRank : all) {
                for (std::size_t bin = 0; bin < bins; ++bin)
                    histogram[static_cast<int>(bin)] += ofRank[i * bins + bin];
            }
        }
        densitiesCounted_ = true;
        return success();
    }

    /// The histograms of all new steps in turn, of this rank's share of their leaves.
    Result<std::vector<std::uint64_t>> countLeaves() const {
        const auto size = static_cast<std::uint64_t>(ranks_.size());
        const auto rank = static_cast<std::uint64_t>(ranks_.rank());
        std::vector<std::uint64_t> all;
        for (std::size_t i = 0; i < places_.size(); ++i) {
            const auto& entry = manifest_.particles().steps(ofDataset(i));
            MOTE_ASSIGN_OR_RETURN(const auto file,
                                  storage::StepFile::open(dataset_->directory() / entry.file(), places_[i]));
            MOTE_ASSIGN_OR_RETURN(const auto bins,
                                  densityHistogram(file, leaves_[i] * rank / size,
                                                   leaves_[i] * (rank + 1) / size, densities_, progress_));
            all.insert(all.end(), bins.begin(), bins.end());
        }
        return all;
    }

    /// Histograms of the steps that are there, over the densities of all steps.
    Status countBaseAnew() {
        for (std::size_t i = 0; i < first_; ++i) {
            if (progress_.cancelled()) return wasCancelled();
            auto& entry = *manifest_.mutable_particles()->mutable_steps(static_cast<int>(i));
            MOTE_ASSIGN_OR_RETURN(const auto step, storage::ParticleStep::open(
                                                       live_->place, *base_, static_cast<std::uint32_t>(i)));
            std::vector<std::uint64_t> bins;
            try {
                const auto leaves = step->leaves();
                addToHistogram(leaves.density, leaves.pointCount, {densities_.min, densities_.max}, bins);
                step->check();
            } catch (const storage::StorageError& error) {
                return error.error();
            }
            entry.mutable_density_histogram()->Assign(bins.begin(), bins.end());
        }
        return success();
    }

    /// How many are left out is said of all steps: what was said when they were fewer goes.
    void keepNotes(proto::ParticlesManifest& particles) {
        const auto counts = leftOutNotes(particles, allGiven(job_), othersLeftOut_);
        for (const auto& sentence : counts) progress_.note(sentence);
        for (const auto& sentence : plotBounds_.notes(axes_)) progress_.note(sentence);
        particles.clear_notes();
        for (const auto& sentence : progress_.notes()) {
            if (!isLeftOutNote(sentence) || std::ranges::count(counts, sentence) > 0)
                particles.add_notes(sentence);
        }
    }

    const proto::JobRequest& request_;
    const proto::ParticlesJob& job_;
    ParticleSource& unfiltered_;
    LostParticles lost_;
    LostFilter source_;
    const std::vector<fs::path>& inputs_;
    fs::path output_;
    const LiveSteps* live_;        ///< null: the dataset is made at once
    const proto::Manifest* base_;  ///< of the live dataset that gets the steps; null: there is none yet
    std::size_t first_;            ///< how many steps that has
    JobResources resources_;
    Communicator& ranks_;
    KeptNotes& progress_;
    std::mutex reporting_;
    double reported_ = 0.0;  ///< under it

    proto::ParticlesJob bounded_;  ///< with the bounds that are known
    PlotAxes axes_;
    KeptColumns columns_;
    std::vector<std::size_t> steps_;  ///< of the source
    StepOptions stepOptions_;
    std::size_t together_ = 1;   ///< steps that are under way at once
    std::uint64_t mayKeep_ = 0;  ///< bytes of what is read, for its next use
    /// Of particles while a step is built, then of its columns.
    const std::shared_ptr<StoreMemory> stores_ = std::make_shared<StoreMemory>();
    RecordStore rows_;                                ///< of the points of the only step, 32 bits each
    std::uint64_t rowBytes_ = 0;                      ///< that it takes; 0: they are not held
    std::vector<std::optional<StepReader>> readers_;  ///< by selected step, from the pass over the bounds
    std::optional<SharedDataset> dataset_;            ///< while it is made
    storage::Writeback writeback_;                    ///< of its files
    std::vector<storage::StepFile::Places> places_;   ///< by selected step
    std::vector<std::uint64_t> leaves_;               ///< by selected step
    PlotBounds plotBounds_;
    Range densities_;
    bool densitiesCounted_ = false;
    bool baseIsOld_ = false;           ///< histograms of the steps that were there are over another scale
    std::uint64_t othersLeftOut_ = 0;  ///< particles that are not lost, of a plot of those that are
    proto::Manifest manifest_;
};

Result<proto::Manifest> runNoted(const proto::JobRequest& request, ParticleSource& source,
                                 const std::vector<fs::path>& inputs, const fs::path& output,
                                 const LiveSteps* live, const JobResources& resources, KeptNotes& progress) {
    const auto alone = singleProcess();
    JobResources all = resources;
    if (!all.ranks) all.ranks = alone.get();
    return onThreads(resources.threads,
                     [&] { return Job(request, source, inputs, output, live, all, progress).run(); });
}

}  // namespace

Result<proto::Manifest> makeLiveSteps(const proto::JobRequest& request, ParticleSource& source,
                                      const std::vector<fs::path>& inputs, const fs::path& output,
                                      const LiveSteps& live, const JobResources& resources,
                                      KeptNotes& progress) {
    return runNoted(request, source, inputs, output, &live, resources, progress);
}

Result<std::unique_ptr<ParticleSource>> openRun(const proto::ParticlesJob& job,
                                                const std::vector<fs::path>& inputs, Progress& progress) {
    return isDataset(inputs) ? openDataset(job, inputs.front()) : openParticleSource(job, inputs, progress);
}

Result<proto::Manifest> runParticlesJob(const proto::JobRequest& request, ParticleSource& source,
                                        const std::vector<fs::path>& inputs, const fs::path& output,
                                        const JobResources& resources, Progress& progress) {
    KeptNotes noted(progress);
    return runNoted(request, source, inputs, output, nullptr, resources, noted);
}

Result<proto::Manifest> runParticlesJob(const proto::JobRequest& request, const std::vector<fs::path>& inputs,
                                        const fs::path& output, const JobResources& resources,
                                        Progress& progress) {
    MOTE_RETURN_IF_ERROR(checkParticlesJob(request.particles()));
    KeptNotes noted(progress);
    auto source = openRun(request.particles(), inputs, noted);
    if (resources.ranks) MOTE_RETURN_IF_ERROR(agree(*resources.ranks, source));
    if (!source.ok()) return source.error();
    return runNoted(request, **source, inputs, output, nullptr, resources, noted);
}

}  // namespace mote::prep
