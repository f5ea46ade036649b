// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/hybrid/step_maker.h"

#include <fmt/format.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "preprocess/hybrid/error_pass.h"
#include "preprocess/hybrid/low_volume.h"
#include "preprocess/hybrid/point_collector.h"
#include "preprocess/hybrid/volume_plan.h"
#include "preprocess/parallel/communicator.h"
#include "storage/files/packed_file.h"
#include "storage/hybrid/hybrid_file.h"
#include "storage/hybrid/residual_encoder.h"
#include "storage/hybrid/residual_file.h"
#include "storage/particles/step_file.h"

namespace mote::prep {
namespace {

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

}  // namespace

Result<proto::HybridStepEntry> makeHybridStep(VolumeSource& source, const StepTask& task) {
    return StepMaker(source, task).make();
}

}  // namespace mote::prep
