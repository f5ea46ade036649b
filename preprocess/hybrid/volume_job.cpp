// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/hybrid/volume_job.h"

#include <fmt/format.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <vector>

#include "preprocess/hybrid/step_maker.h"
#include "preprocess/hybrid/value_range.h"
#include "preprocess/hybrid/volume_plan.h"
#include "preprocess/job.h"
#include "preprocess/kept_notes.h"
#include "preprocess/new_dataset.h"
#include "preprocess/on_threads.h"
#include "preprocess/parallel/communicator.h"
#include "protocol/mote.pb.h"
#include "storage/manifest.h"

namespace mote::prep {
namespace {

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
                defaultThreshold));
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
        return Error{ErrorCode::invalidArgument, inputs_[step].string(),
                     fmt::format("has another size or place than {}: the steps of a dataset share both",
                                 inputs_.front().string())};
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
        return Error{ErrorCode::unsupported, inputs_.front().string(), "has values further apart than 1e37"};
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
    for (const auto& step : steps) names.push_back(step.input);
    return runNoted(request, open, {inputs, names}, output, resources, progress);
}

}  // namespace mote::prep
