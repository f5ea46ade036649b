// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/hybrid/volume_job.h"

#include <fmt/format.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

#include "preprocess/hybrid/error_pass.h"
#include "preprocess/hybrid/low_volume.h"
#include "preprocess/hybrid/point_collector.h"
#include "preprocess/hybrid/value_range.h"
#include "preprocess/hybrid/volume_plan.h"
#include "preprocess/kept_notes.h"
#include "preprocess/new_dataset.h"
#include "preprocess/on_threads.h"
#include "preprocess/parallel/communicator.h"
#include "preprocess/world_unit.h"
#include "protocol/scene/dataset.h"
#include "storage/files/packed_file.h"
#include "storage/hybrid/hybrid_file.h"
#include "storage/hybrid/residual_encoder.h"
#include "storage/hybrid/residual_file.h"
#include "storage/manifest.h"
#include "storage/particles/step_file.h"

namespace mote::prep {
namespace {

// One step of a hybrid volume: its files from its source. Called from one thread on every rank; works on the
// caller's oneTBB threads. The same source gives the same bytes for any number of ranks and threads and any
// memory.

struct StepTask {
    Communicator& ranks;
    const VolumePlan& plan;
    const ValueRange& range;  ///< of all steps
    const VolumeMemory& memory;
    std::filesystem::path directory;  ///< of the dataset while it is made
    std::uint32_t step = 0;
    /// The share of the step's time, measured, by which all errors are found.
    static constexpr double errorsEnd = 0.85;
    /// Takes the done share of this step, 0 to 1, and what is done; an error ends the step.
    std::function<Status(double, std::string_view)> report;
};

// The files of a step of a hybrid volume from what all ranks have put aside. Functions without state; called
// on every rank, from one thread.

/// What a rank has put aside, in its scratch file.
struct CollectedErrors {
    std::vector<PointPiece> points;
    std::vector<storage::ResidualPart> residuals;
};

/// What all ranks know alike.
struct StepContent {
    const LowVolume& low;
    const ErrorSelection& selection;
    const storage::ResidualCoding& coding;  ///< where there are residuals
};

/// The share of the step's time, measured, after which residuals are written.
constexpr double residualsBegin = 0.92;

using Scratches = std::vector<std::unique_ptr<storage::ScratchFile>>;

/// Where a rank's scratch file lies.
std::filesystem::path scratchPath(const StepTask& task, int rank) {
    return task.directory / fmt::format("scratch-{}", rank);
}

/// Everyone's, each told whose scratch file it lies in.
template <class T>
Result<std::vector<T>> shareParts(Communicator& ranks, const std::vector<T>& mine) {
    MOTE_ASSIGN_OR_RETURN(const auto all, shareValues<T>(ranks, std::span<const T>(mine)));
    std::vector<T> parts;
    for (std::size_t rank = 0; rank < all.size(); ++rank) {
        for (auto part : all[rank]) {
            part.scratch = static_cast<std::uint32_t>(rank);
            parts.push_back(part);
        }
    }
    return parts;
}

class StepOutput {
  public:
    StepOutput(const StepTask& task, const StepContent& content, CollectedErrors all,
               proto::HybridStepEntry& entry)
        : task_(task), plan_(task.plan), content_(content), all_(std::move(all)), entry_(entry) {}

    Status write() {
        for (int rank = 0; rank < task_.ranks.size(); ++rank) {
            MOTE_ASSIGN_OR_RETURN(auto scratch, storage::ScratchFile::open(scratchPath(task_, rank)));
            scratches_.push_back(std::move(scratch));
        }
        MOTE_RETURN_IF_ERROR(writeArrays());
        if (!plan_.residual) return success();
        MOTE_RETURN_IF_ERROR(task_.report(residualsBegin, "writing residuals"));
        std::uint64_t samples = 0;
        std::uint64_t bricks = 0;
        for (const auto& part : all_.residuals) {
            samples += part.samples;
            bricks += part.bricks;
        }
        entry_.set_residual_samples(samples);
        entry_.set_residual_bricks(bricks);
        const auto name = storage::residualName(task_.step);
        MOTE_RETURN_IF_ERROR(
            storage::writeResidual(task_.directory / name, content_.coding, all_.residuals, scratches_));
        return pack(name, *entry_.mutable_residual_file());
    }

  private:
    Status writeArrays() {
        const PointPieces points{std::move(all_.points), scratches_, content_.selection.mostOfLeast};
        if (plan_.pointBytes > 0) entry_.set_points(points.size());
        const auto name = storage::stepName(task_.step);
        MOTE_ASSIGN_OR_RETURN(const auto file,
                              storage::HybridStepWriter::create(task_.directory, name,
                                                                {plan_.low, plan_.valueBits, plan_.pointBytes,
                                                                 plan_.error, entry_.points()}));
        entry_.set_digest(name + ".digest");
        const auto normals = lowNormals(content_.low, gridToWorld(plan_, plan_.low));
        MOTE_RETURN_IF_ERROR(file.writeLow(content_.low.codes(), normals));
        const auto progress = [&] { return task_.report(StepTask::errorsEnd, "writing"); };
        if (plan_.pointBytes > 0) {
            MOTE_RETURN_IF_ERROR(writePoints(points, plan_.error, plan_.pointBytes, progress, file));
        }
        MOTE_RETURN_IF_ERROR(file.finish());
        return pack(name + ".h5", *entry_.mutable_file());
    }

    /// `packed`: the name that the file has then.
    Status pack(const std::string& name, std::string& packed) const {
        packed = name + std::string(storage::packedSuffix);
        return storage::packFile(task_.directory / name);
    }

    const StepTask& task_;
    const VolumePlan& plan_;
    const StepContent& content_;
    CollectedErrors all_;
    proto::HybridStepEntry& entry_;
    Scratches scratches_;
};

/// Rank 0 reads everyone's scratch files and writes the step's files; sets their names and counts in its
/// `entry`. Errors, on all ranks: resourceExhausted (disk full), internal, cancelled.
Status writeStep(const StepTask& task, const StepContent& content, const CollectedErrors& mine,
                 proto::HybridStepEntry& entry) {
    MOTE_ASSIGN_OR_RETURN(auto points, shareParts(task.ranks, mine.points));
    MOTE_ASSIGN_OR_RETURN(auto residuals, shareParts(task.ranks, mine.residuals));
    StepOutput output(task, content, {std::move(points), std::move(residuals)}, entry);
    return agree(task.ranks, task.ranks.first() ? output.write() : success());
}

/// Shares of the step's time, measured: when filtering ends, and when all passes over the errors have.
constexpr double filterEnd = 0.3, errorsEnd = StepTask::errorsEnd;

class StepMaker {
  public:
    StepMaker(VolumeSource& source, const StepTask& task)
        : source_(source),
          task_(task),
          plan_(task.plan),
          ranks_(task.ranks),
          part_(partOf(plan_, ranks_.rank(), ranks_.size())) {}

    Result<proto::HybridStepEntry> make() {
        MOTE_RETURN_IF_ERROR(makeLow());
        pass_.emplace(source_, plan_, task_.range, low_, task_.memory.slices);
        MOTE_RETURN_IF_ERROR(select());
        auto scratch = storage::ScratchFile::create(scratchPath(task_, ranks_.rank()));
        MOTE_RETURN_IF_ERROR(agree(ranks_, scratch.ok() ? collect(**scratch) : Status(scratch.error())));
        MOTE_RETURN_IF_ERROR(writeStep(task_, {low_, selection_, coding_}, collected_, entry_));
        return entry_;
    }

  private:
    Status makeLow() {
        ValueHistogram histogram{};
        std::vector<float> mine;
        MOTE_RETURN_IF_ERROR(agree(ranks_, filter(histogram, mine)));
        MOTE_RETURN_IF_ERROR(addUp(histogram));
        std::vector<float> values(storage::samplesOf(plan_.low));
        MOTE_RETURN_IF_ERROR(gather(mine, values));
        mine = {};
        // A constant volume is overestimated by roundings at most, which are not to be lowered.
        const bool constant = !(task_.range.span() > 0.0);
        if (plan_.filter == LowFilter::under && !constant) MOTE_RETURN_IF_ERROR(lower(values));
        low_ = encodeLow(plan_, task_.range, values);
        entry_.set_value_min(low_.min);
        entry_.set_value_step(low_.step);
        entry_.mutable_histogram()->Assign(histogram.begin(), histogram.end());
        return success();
    }

    /// This rank's slices of the low-resolution volume, and the histogram of its slices of the source.
    Status filter(ValueHistogram& histogram, std::vector<float>& low) {
        const auto& own = part_.source;
        const auto seen = [&](const SlabWindow& window, std::uint32_t z0, std::uint32_t z1) {
            tbb::enumerable_thread_specific<ValueHistogram> parts(ValueHistogram{});
            tbb::parallel_for(
                std::max(z0, own.begin), std::max(std::min(z1, own.end), own.begin),
                [&](std::uint32_t z) { addToHistogram(window.slice(z), task_.range, parts.local()); });
            for (const auto& part : parts) {
                for (std::size_t i = 0; i < part.size(); ++i) histogram[i] += part[i];
            }
            return task_.report(filterEnd * done(z0, own), "filtering");
        };
        MOTE_ASSIGN_OR_RETURN(low, filterSlices(source_, plan_, task_.range, part_.low.begin, part_.low.end,
                                                task_.memory.slices, seen));
        return success();
    }

    /// What of a range lies below a slice.
    static double done(std::uint32_t z, const SliceRange& range) {
        if (z <= range.begin || range.begin == range.end) return 0.0;
        return static_cast<double>(std::min(z, range.end) - range.begin) / (range.end - range.begin);
    }

    /// Everyone's counts into this rank's.
    Status addUp(std::span<std::uint64_t> counts) {
        MOTE_ASSIGN_OR_RETURN(const auto all, shareValues<std::uint64_t>(ranks_, counts));
        std::fill(counts.begin(), counts.end(), 0);
        for (const auto& some : all) {
            for (std::size_t i = 0; i < counts.size(); ++i) counts[i] += some[i];
        }
        return success();
    }

    /// The low-resolution volume from everyone's slices.
    Status gather(std::span<const float> mine, std::vector<float>& low) {
        const std::size_t slice = std::size_t{plan_.low[0]} * plan_.low[1];
        return sharePieces(ranks_, mine, [&](std::size_t rank, std::uint64_t first, auto values) {
            const auto part = partOf(plan_, static_cast<int>(rank), ranks_.size());
            const auto at = part.low.begin * slice + first;
            std::copy(values.begin(), values.end(), low.begin() + static_cast<std::ptrdiff_t>(at));
        });
    }

    Status lower(std::vector<float>& low) {
        std::vector<float> falls(low.size());
        const auto report = [&](std::uint32_t) { return task_.report(filterEnd, "lowering"); };
        MOTE_RETURN_IF_ERROR(agree(ranks_, findFalls(source_, plan_, task_.range, low, part_.source.begin,
                                                     part_.source.end, task_.memory.slices, report, falls)));
        std::vector<float> greatest(falls.size());
        MOTE_RETURN_IF_ERROR(sharePieces(ranks_, std::span<const float>(falls),
                                         [&](std::size_t, std::uint64_t first, auto some) {
                                             for (std::size_t i = 0; i < some.size(); ++i) {
                                                 greatest[first + i] = std::max(greatest[first + i], some[i]);
                                             }
                                         }));
        for (std::size_t i = 0; i < low.size(); ++i) low[i] -= greatest[i];
        return success();
    }

    /// This rank's slabs.
    Status eachSlab(double begin, double end, std::string_view what,
                    const std::function<Status(const ErrorSlab&)>& visit) {
        return pass_->run(part_.error.begin, part_.error.end, [&](const ErrorSlab& slab) -> Status {
            const double share = done(slab.z0, part_.error);
            MOTE_RETURN_IF_ERROR(task_.report(begin + (end - begin) * share, what));
            return visit(slab);
        });
    }

    Status select() {
        if (!plan_.maxPoints) {
            selection_.threshold = static_cast<float>(plan_.threshold * task_.range.span());
            return success();
        }
        ErrorCount upper;
        MOTE_RETURN_IF_ERROR(count(upper, filterEnd, filterEnd + 0.18));
        const auto place = upper.find(*plan_.maxPoints);
        if (place.fewer) return success();
        ErrorCount lower(place.bin);
        MOTE_RETURN_IF_ERROR(count(lower, filterEnd + 0.18, filterEnd + 0.36));
        selection_ = selectGreatest(lower, place.bin, *plan_.maxPoints, place.above);
        return success();
    }

    /// Counts the errors of all ranks.
    Status count(ErrorCount& counts, double begin, double end) {
        ErrorCount mine = counts.empty();
        MOTE_RETURN_IF_ERROR(
            agree(ranks_, eachSlab(begin, end, "counting errors", [&](const ErrorSlab& slab) {
                      tbb::enumerable_thread_specific<ErrorCount> parts(counts.empty());
                      tbb::parallel_for(slab.z0, slab.z1, [&](std::uint32_t z) {
                          parts.local().add({slab.error(z), slab.slice()});
                      });
                      for (const auto& part : parts) mine.add(part.bins());
                      return success();
                  })));
        std::vector<std::uint64_t> bins(mine.bins().begin(), mine.bins().end());
        MOTE_RETURN_IF_ERROR(addUp(bins));
        counts.add(bins);
        return success();
    }

    Status collect(storage::ScratchFile& scratch) {
        const double lowMax = low_.min + low_.step * (plan_.valueBits == 8 ? 255 : 65535);
        const auto& range = task_.range;
        const double greatest = std::max(range.max - low_.min, lowMax - range.min);
        entry_.set_error_step(greatest / 127);
        entry_.set_threshold(selection_.threshold);
        std::optional<PointCollector> points;
        if (plan_.pointBytes > 0) {
            points.emplace(plan_, PointCoding{range.min, range.span(), entry_.error_step()}, selection_,
                           scratch);
        }
        if (plan_.residual) {
            entry_.set_residual_step(residualStep(range, source_.shape().valueStep, selection_.threshold));
            coding_ = {plan_.error, entry_.residual_step(), gridToWorld(plan_, plan_.error),
                       storage::fitHalves(greatest / entry_.residual_step() + 1.0, entry_.residual_step())};
        }
        MOTE_RETURN_IF_ERROR(eachSlab(plan_.maxPoints ? filterEnd + 0.36 : filterEnd, errorsEnd,
                                      "taking errors",
                                      [&](const ErrorSlab& slab) { return take(slab, points, scratch); }));
        if (points) collected_.points = points->pieces();
        return ranks_.size() > 1 ? scratch.sync() : success();
    }

    Status take(const ErrorSlab& slab, std::optional<PointCollector>& points, storage::ScratchFile& scratch) {
        if (points) MOTE_RETURN_IF_ERROR(points->add(slab));
        if (!plan_.residual) return success();
        MOTE_ASSIGN_OR_RETURN(const auto parts, residualParts(slab, selection_, coding_, scratch));
        collected_.residuals.insert(collected_.residuals.end(), parts.begin(), parts.end());
        return success();
    }

    VolumeSource& source_;
    const StepTask& task_;
    const VolumePlan& plan_;
    Communicator& ranks_;
    RankPart part_;
    LowVolume low_;
    std::optional<ErrorPass> pass_;
    ErrorSelection selection_;
    storage::ResidualCoding coding_;
    CollectedErrors collected_;
    proto::HybridStepEntry entry_;
};

/// Makes step-%06d.h5, .digest and residual-%06d.vdb; returns their entry, but for time and invalid samples,
/// which is whole on rank 0 alone. `source` is this rank's own. Errors: those of any rank's source,
/// resourceExhausted (disk), cancelled.
Result<proto::HybridStepEntry> makeHybridStep(VolumeSource& source, const StepTask& task) {
    return StepMaker(source, task).make();
}

// What the manifest of a hybrid volume says before any of its steps is made. A pure function, but for the
// names of the file system.

namespace fs = std::filesystem;

/// Names the inputs as they are seen from the folder that holds the dataset.
void nameInputs(const std::vector<fs::path>& inputs, const fs::path& output, proto::VolumeJob& job) {
    const auto given = static_cast<std::size_t>(job.inputs_size());
    auto& names = *job.mutable_inputs();
    names.Clear();
    for (const auto& input : inputs) {
        // A file of several steps is named once.
        const auto name = portableInput(input, output);
        const bool again = inputs.size() > given && !names.empty() && *names.rbegin() == name;
        if (!again) names.Add(std::string(name));
    }
}

proto::Manifest describeVolume(const proto::JobRequest& request, const std::vector<fs::path>& inputs,
                               const fs::path& output, const VolumeShape& shape, const VolumePlan& plan,
                               const ValueRange& range) {
    auto manifest = beginManifest("hybrid", request, inputs.front().filename().string());
    nameInputs(inputs, output, *manifest.mutable_request()->mutable_volume());
    auto& hybrid = *manifest.mutable_hybrid();
    hybrid.mutable_source_size()->Assign(plan.source.begin(), plan.source.end());
    hybrid.mutable_low_size()->Assign(plan.low.begin(), plan.low.end());
    hybrid.mutable_error_size()->Assign(plan.error.begin(), plan.error.end());
    for (int i = 0; i < 16; ++i) hybrid.add_index_to_world(plan.indexToWorld[i % 4][i / 4]);
    hybrid.set_value_min(range.min);
    hybrid.set_value_max(range.max);
    hybrid.set_scalar_type(std::string(name(shape.type)));
    hybrid.set_value_unit(shape.valueUnit);
    hybrid.set_world_unit(shape.worldUnit);
    hybrid.set_filter(request.volume().filter().empty() ? "cubic" : request.volume().filter());
    hybrid.set_value_bits(plan.valueBits);
    hybrid.set_point_bytes(plan.pointBytes);
    hybrid.set_residual(plan.residual);
    hybrid.set_source_space(shape.space);
    hybrid.set_space(shape.worldSpace);
    return manifest;
}

/// The share of the job's time that finding the range takes.
constexpr double rangeShare = 0.15;
/// Differences of floats must be floats.
constexpr double greatestSpan = 1e37;

/// What was given, and what each step is of: a file may hold several steps, several files may be one.
struct Inputs {
    const std::vector<fs::path>& given;
    const std::vector<fs::path>& steps;
};

class Job {
  public:
    Job(const proto::JobRequest& request, const OpenVolume& open, const Inputs& inputs,
        const fs::path& output, const JobResources& resources, KeptNotes& progress)
        : request_(request),
          open_(open),
          given_(inputs.given),
          inputs_(inputs.steps),
          output_(output),
          resources_(resources),
          ranks_(*resources.ranks),
          progress_(progress) {}

    Result<proto::Manifest> run() {
        MOTE_RETURN_IF_ERROR(agree(ranks_, check()));
        // Before the work: a place that cannot be had is said at once.
        MOTE_ASSIGN_OR_RETURN(auto dataset, SharedDataset::create(ranks_, output_));
        if (!request_.volume().has_threshold() && !request_.volume().has_max_points()) {
            progress_.note(fmt::format(
                "errors above {} of the range of values are taken: --threshold says another share",
                plan_.threshold));
        }
        MOTE_RETURN_IF_ERROR(findRanges());
        auto manifest = describeVolume(request_, given_, output_, shape_, plan_, range_);
        for (std::size_t step = 0; step < inputs_.size(); ++step) {
            auto entry = makeStep(step, dataset.directory());
            if (!entry.ok()) return inInput(step, entry.error());
            MOTE_RETURN_IF_ERROR(
                agree(ranks_, ranks_.first() ? addFiles(*entry, dataset.writer()) : success()));
            *manifest.mutable_hybrid()->add_steps() = *std::move(entry);
        }
        if (takenForPatient(manifest)) {
            progress_.note(
                "it says no space; its slices are taken to lie as scanners write them, from feet to head "
                "with the back last: --up and --front say where it stands otherwise");
        }
        const auto& notes = progress_.notes();
        manifest.mutable_hybrid()->mutable_notes()->Assign(notes.begin(), notes.end());
        MOTE_RETURN_IF_ERROR(agree(
            ranks_, ranks_.first() ? publishDataset(dataset.writer(), manifest, progress_) : success()));
        dataset.finish();
        progress_.report(1.0, "done");
        return manifest;
    }

  private:
    Status check() const {
        MOTE_RETURN_IF_ERROR(checkVolumeJob(request_.volume()));
        if (inputs_.size() <= static_cast<std::size_t>(storage::maxSteps)) return success();
        return Error{ErrorCode::resourceExhausted, "inputs",
                     fmt::format("are more than the {} steps that one dataset holds", storage::maxSteps)};
    }

    /// An error that names no place is one of the input's.
    Error inInput(std::size_t step, const Error& error) const {
        if (!error.where.empty() || error.code == ErrorCode::cancelled) return error;
        return {error.code, inputs_[step].string(), error.message, error.passing};
    }

    /// The plan follows from the first volume; the others must be like it.
    Status planFrom(const VolumeShape& shape) {
        shape_ = shape;
        MOTE_ASSIGN_OR_RETURN(shape_.worldUnit, worldUnitFor(request_, shape, progress_));
        MOTE_ASSIGN_OR_RETURN(plan_, planVolume(request_.volume(), shape));
        MOTE_ASSIGN_OR_RETURN(memory_,
                              planMemory(plan_, resources_.memory, tbb::this_task_arena::max_concurrency()));
        return success();
    }

    Status checkLikeFirst(std::size_t step, const VolumeShape& shape) const {
        if (shape.nx == shape_.nx && shape.ny == shape_.ny && shape.nz == shape_.nz &&
            shape.indexToWorld == shape_.indexToWorld) {
            return success();
        }
        return invalid(inputs_[step].string(),
                       fmt::format("has another size or place than {}: the steps of a dataset share both",
                                   inputs_.front().string()));
    }

    Status findRanges() {
        for (std::size_t step = 0; step < inputs_.size(); ++step) {
            const auto range = rangeOf(step);
            MOTE_RETURN_IF_ERROR(agree(ranks_, range.ok() ? success() : inInput(step, range.error())));
            MOTE_ASSIGN_OR_RETURN(const auto all, shareValues<ValueRange>(ranks_, std::span(&*range, 1)));
            auto& united = ranges_.emplace_back();
            for (const auto& of : all) united = united.united(of.front());
            range_ = range_.united(united);
        }
        noteInvalid();
        if (range_.span() <= greatestSpan) return success();
        return unsupported(inputs_.front().string(), "has values further apart than 1e37");
    }

    /// The range of this rank's slices.
    Result<ValueRange> rangeOf(std::size_t step) {
        MOTE_ASSIGN_OR_RETURN(auto source, open_(step));
        const auto& shape = source->shape();
        MOTE_RETURN_IF_ERROR(step == 0 ? planFrom(shape) : checkLikeFirst(step, shape));
        progress_.report(rangeShare * static_cast<double>(step) / static_cast<double>(inputs_.size()),
                         phase("looking for the range of", step));
        const auto own = partOf(plan_, ranks_.rank(), ranks_.size()).source;
        auto range =
            findRange(*source, own.begin, own.end, memory_.slices, [this] { return progress_.cancelled(); });
        if (inputs_.size() == 1) only_ = std::move(source);
        return range;
    }

    void noteInvalid() {
        if (range_.invalid == 0) return;
        progress_.note(fmt::format("{} samples are not finite numbers and were taken as the least value, {}",
                                   range_.invalid, range_.min));
    }

    std::string phase(std::string_view what, std::size_t step) const {
        return inputs_.size() == 1 ? fmt::format("{} volume", what)
                                   : fmt::format("{} volume {} of {}", what, step + 1, inputs_.size());
    }

    Result<proto::HybridStepEntry> makeStep(std::size_t step, const fs::path& directory) {
        auto source = only_ ? Result(std::move(only_)) : open_(step);
        MOTE_RETURN_IF_ERROR(agree(ranks_, source));
        StepTask task{ranks_, plan_, range_, memory_, directory, static_cast<std::uint32_t>(step), {}};
        task.report = [&](double done, std::string_view what) -> Status {
            if (progress_.cancelled()) return wasCancelled();
            const double all = (static_cast<double>(step) + done) / static_cast<double>(inputs_.size());
            progress_.report(rangeShare + (0.97 - rangeShare) * all, phase(fmt::format("{}:", what), step));
            return success();
        };
        MOTE_ASSIGN_OR_RETURN(auto entry, makeHybridStep(**source, task));
        entry.set_time((*source)->time().value_or(static_cast<double>(step)));
        entry.set_invalid(ranges_[step].invalid);
        return entry;
    }

    Status addFiles(const proto::HybridStepEntry& entry, storage::DatasetWriter& writer) const {
        const auto stop = [this] { return progress_.cancelled(); };
        MOTE_RETURN_IF_ERROR(writer.add(entry.file(), stop));
        MOTE_RETURN_IF_ERROR(writer.add(entry.digest(), stop));
        return entry.residual_file().empty() ? success() : writer.add(entry.residual_file(), stop);
    }

    const proto::JobRequest& request_;
    const OpenVolume& open_;
    const std::vector<fs::path>&given_, &inputs_;
    fs::path output_;
    JobResources resources_;
    Communicator& ranks_;
    KeptNotes& progress_;

    VolumeShape shape_;
    VolumePlan plan_;
    VolumeMemory memory_;
    std::vector<ValueRange> ranges_;      ///< by step
    ValueRange range_;                    ///< of all steps
    std::unique_ptr<VolumeSource> only_;  ///< of a single step: opened once
};

/// Opens the volume of an input, by its index, and notes what was assumed.
using OpenNoted = std::function<Result<std::unique_ptr<VolumeSource>>(std::size_t, Progress&)>;

Result<proto::Manifest> runNoted(const proto::JobRequest& request, const OpenNoted& open,
                                 const Inputs& inputs, const fs::path& output, const JobResources& resources,
                                 Progress& progress) {
    const auto alone = singleProcess();
    JobResources all = resources;
    if (!all.ranks) all.ranks = alone.get();
    KeptNotes kept(progress);
    const OpenVolume noting = [&](std::size_t step) { return open(step, kept); };
    return onThreads(resources.threads,
                     [&] { return Job(request, noting, inputs, output, all, kept).run(); });
}

}  // namespace

Result<proto::Manifest> runVolumeJob(const proto::JobRequest& request, const OpenVolume& open,
                                     const std::vector<fs::path>& inputs, const fs::path& output,
                                     const JobResources& resources, Progress& progress) {
    return runNoted(
        request, [&](std::size_t step, Progress&) { return open(step); }, {inputs, inputs}, output, resources,
        progress);
}

Result<proto::Manifest> runVolumeJob(const proto::JobRequest& request,
                                     const std::vector<std::filesystem::path>& inputs,
                                     const std::filesystem::path& output, const JobResources& resources,
                                     Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(const auto steps, volumeSteps(request.volume().source(), inputs));
    const OpenNoted open = [&](std::size_t index, Progress& noted) {
        return openVolumeSource(steps[index], noted);
    };
    std::vector<fs::path> names;
    names.reserve(steps.size());
    for (const auto& step : steps) names.push_back(step.input);
    return runNoted(request, open, {inputs, names}, output, resources, progress);
}

}  // namespace mote::prep
