// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/step_maker.h"

#include <fmt/format.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <optional>

#include "preprocess/volume/error_selection.h"
#include "preprocess/volume/low_volume.h"
#include "preprocess/volume/residual_collector.h"
#include "preprocess/volume/stored_points.h"
#include "preprocess/volume/under_filter.h"
#include "storage/hybrid/hybrid_file.h"
#include "storage/hybrid/residual_file.h"
#include "storage/particles/step_writer.h"

namespace mote::prep {
namespace {

/// Of the step's time, measured: filtering, then each pass over the errors.
constexpr double filterEnd = 0.3, errorsEnd = 0.85;
/// A collected point's bytes, twice while vectors grow, and those of its form on disk.
constexpr std::uint64_t bytesPerPoint = 24;

class StepMaker {
  public:
    StepMaker(VolumeSource& source, const StepTask& task) : source_(source), task_(task), plan_(task.plan) {}

    Result<proto::HybridStepEntry> make() {
        MOTE_RETURN_IF_ERROR(makeLow());
        pass_.emplace(source_, plan_, task_.range, low_, task_.memory.slices);
        MOTE_RETURN_IF_ERROR(select());
        MOTE_RETURN_IF_ERROR(collect());
        MOTE_RETURN_IF_ERROR(task_.report(errorsEnd, "writing"));
        MOTE_RETURN_IF_ERROR(write());
        return entry_;
    }

  private:
    Status makeLow() {
        ValueHistogram histogram{};
        const auto seen = [&](const SlabWindow& window, std::uint32_t z0, std::uint32_t z1) {
            tbb::enumerable_thread_specific<ValueHistogram> parts(ValueHistogram{});
            tbb::parallel_for(z0, z1, [&](std::uint32_t z) {
                addToHistogram(window.slice(z), task_.range, parts.local());
            });
            for (const auto& part : parts) {
                for (std::size_t i = 0; i < part.size(); ++i) histogram[i] += part[i];
            }
            return task_.report(filterEnd * z0 / plan_.source[2], "filtering");
        };
        auto values = filterSlices(source_, plan_, task_.range, 0, plan_.low[2], task_.memory.slices, seen);
        if (!values.ok()) return values.error();
        // A constant volume is overestimated by roundings at most, which are not to be lowered.
        const bool constant = !(task_.range.span() > 0.0);
        if (plan_.filter == LowFilter::under && !constant) MOTE_RETURN_IF_ERROR(lower(*values));
        low_ = encodeLow(plan_, task_.range, *values);
        entry_.set_value_min(low_.min);
        entry_.set_value_step(low_.step);
        entry_.mutable_histogram()->Assign(histogram.begin(), histogram.end());
        return success();
    }

    Status lower(std::vector<float>& low) {
        std::vector<float> falls(low.size());
        const auto report = [&](std::uint32_t) { return task_.report(filterEnd, "lowering"); };
        MOTE_RETURN_IF_ERROR(findFalls(source_, plan_, task_.range, low, 0, plan_.source[2],
                                       task_.memory.slices, report, falls));
        for (std::size_t i = 0; i < low.size(); ++i) low[i] -= falls[i];
        return success();
    }

    Status eachSlab(double begin, double end, std::string_view what,
                    const std::function<Status(const ErrorSlab&)>& visit) {
        return pass_->run(0, plan_.error[2], [&](const ErrorSlab& slab) -> Status {
            const double done = static_cast<double>(slab.z0) / plan_.error[2];
            MOTE_RETURN_IF_ERROR(task_.report(begin + (end - begin) * done, what));
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

    Status count(ErrorCount& counts, double begin, double end) {
        return eachSlab(begin, end, "counting errors", [&](const ErrorSlab& slab) {
            const ErrorCount none = counts.empty();
            tbb::enumerable_thread_specific<ErrorCount> parts(none);
            tbb::parallel_for(slab.z0, slab.z1, [&](std::uint32_t z) {
                parts.local().add({slab.error(z), slab.slice()});
            });
            for (const auto& part : parts) counts.add(part.bins());
            return success();
        });
    }

    Status collect() {
        const double threshold = selection_.threshold;
        const double lowMax = low_.min + low_.step * (plan_.valueBits == 8 ? 255 : 65535);
        const auto& range = task_.range;
        entry_.set_error_step(std::max(range.max - low_.min, lowMax - range.min) / 127);
        entry_.set_threshold(threshold);
        if (plan_.pointBytes > 0) {
            points_.emplace(plan_, PointCoding{range.min, range.span(), entry_.error_step()}, selection_);
        }
        if (plan_.residual) {
            entry_.set_residual_step(residualStep(range, threshold));
            residual_.emplace(plan_.error, entry_.residual_step(), gridToWorld(plan_, plan_.error));
        }
        return eachSlab(plan_.maxPoints ? filterEnd + 0.36 : filterEnd, errorsEnd, "taking errors",
                        [&](const ErrorSlab& slab) { return take(slab); });
    }

    Status take(const ErrorSlab& slab) {
        if (points_) points_->add(slab);
        if (residual_) {
            for (const auto& brick : residualBricks(slab, selection_, entry_.residual_step())) {
                residual_->add(brick.index, brick.multiples);
            }
        }
        const auto used = (points_ ? points_->size() * bytesPerPoint : 0) +
                          (residual_ ? residual_->bricks() * storage::ResidualGrid::bytesPerBrick : 0);
        if (used <= task_.memory.results) return success();
        return Error{ErrorCode::resourceExhausted, "",
                     fmt::format("after {} of {} slices the errors found take {} MiB, all that the memory "
                                 "leaves for them; a larger threshold or a coarser error grid needs less",
                                 slab.z1, plan_.error[2], used >> 20)};
    }

    Status write() {
        const auto normals = lowNormals(low_, gridToWorld(plan_, plan_.low));
        storage::HybridStepContent content{plan_.low, low_.codes(), normals, nullptr};
        std::optional<StoredPoints> stored;
        storage::HybridPoints view;
        if (points_) {
            auto collected = points_->take();
            collected.limitLeast(selection_.mostOfLeast);
            stored.emplace(std::move(collected), plan_.error, plan_.pointBytes);
            view = stored->view();
            content.points = &view;
            entry_.set_points(view.size());
        }
        const auto name = storage::stepName(task_.step);
        MOTE_RETURN_IF_ERROR(storage::writeHybridStep(task_.directory, name, content));
        entry_.set_file(name + ".h5");
        entry_.set_digest(name + ".digest");
        if (!residual_) return success();
        MOTE_RETURN_IF_ERROR(task_.report(errorsEnd + 0.02, "writing residuals"));
        entry_.set_residual_file(storage::residualName(task_.step));
        entry_.set_residual_samples(residual_->samples());
        entry_.set_residual_bricks(residual_->bricks());
        return residual_->write(task_.directory / entry_.residual_file());
    }

    VolumeSource& source_;
    const StepTask& task_;
    const VolumePlan& plan_;
    LowVolume low_;
    std::optional<ErrorPass> pass_;
    ErrorSelection selection_;
    std::optional<PointCollector> points_;
    std::optional<storage::ResidualGrid> residual_;
    proto::HybridStepEntry entry_;
};

}  // namespace

Result<proto::HybridStepEntry> makeHybridStep(VolumeSource& source, const StepTask& task) {
    return StepMaker(source, task).make();
}

}  // namespace mote::prep
