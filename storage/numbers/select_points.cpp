// SPDX-License-Identifier: GPL-3.0-or-later
//
// A selection is made ready for a step as a tree of conditions; then each block of points goes through the
// tree by itself.
#include "storage/numbers/select_points.h"

#include <fmt/format.h>
#include <oneapi/tbb/enumerable_thread_specific.h>

#include <map>

#include "storage/numbers/id_set.h"
#include "storage/numbers/point_conditions.h"
#include "storage/numbers/scan.h"

namespace mote::storage {
namespace {

class Selector {
  public:
    Selector(const RunSteps& run, const std::function<bool()>& cancelled)
        : run_(run), cancelled_(cancelled) {}

    Result<PointMask> select(const Selection& selection, std::uint32_t step) {
        MOTE_ASSIGN_OR_RETURN(const auto condition, make(selection, step));
        const auto& points = *numbers_.at(step).points;
        PointMask mask(points.pointCount());
        tbb::enumerable_thread_specific<PointCondition::Scratch> scratch;
        const bool whole = forBlocks(blockCount(mask.size()), cancelled_, [&](std::uint64_t block) {
            const auto part = pointsOfBlock(block, mask.size());
            const auto words =
                std::span(mask.words()).subspan(part.begin / PointMask::wordBits, wordCount(part.count));
            std::ranges::fill(words, ~std::uint64_t{0});
            if (const auto over = part.count % PointMask::wordBits; over != 0)
                words.back() = (std::uint64_t{1} << over) - 1;
            condition->keep(part, words, scratch.local());
        });
        if (!whole) return wasCancelled();
        points.check();
        if (const auto& columns = numbers_.at(step).columns) columns->check();
        return mask;
    }

  private:
    /// Kept as long as the conditions that read it.
    Result<const StepNumbers*> numbers(std::uint32_t step) {
        const auto found = numbers_.find(step);
        if (found != numbers_.end()) return &found->second;
        if (const auto steps = run_.manifest().steps_size(); step >= static_cast<std::uint32_t>(steps))
            return Error{ErrorCode::notFound, "step",
                         fmt::format("the run has {} steps, so none with index {}", steps, step)};
        MOTE_ASSIGN_OR_RETURN(auto opened, run_.step(step));
        return &numbers_.emplace(step, std::move(opened)).first->second;
    }

    /// Errors where the step has no columns, or no ids where they are asked for.
    static Status needColumns(const StepNumbers& step, bool ids) {
        if (step.columns && (!ids || step.columns->hasIds())) return success();
        return step.columns ? withoutIds("") : withoutColumns("");
    }

    MadeCondition make(const Selection& selection, std::uint32_t step) {
        if (selection.step && *selection.step != step) return sameIds(selection, *selection.step, step);
        MOTE_ASSIGN_OR_RETURN(const auto* const numbers, this->numbers(step));
        PointConditions parts;
        MOTE_RETURN_IF_ERROR(addOwn(selection, *numbers, parts));
        for (std::size_t i = 0; i < selection.all.size(); ++i) {
            auto part = make(selection.all[i], step);
            MOTE_RETURN_IF_ERROR(part, fmt::format("all[{}]", i));
            parts.push_back(*std::move(part));
        }
        PointConditions any;
        for (std::size_t i = 0; i < selection.any.size(); ++i) {
            auto part = make(selection.any[i], step);
            MOTE_RETURN_IF_ERROR(part, fmt::format("any[{}]", i));
            any.push_back(*std::move(part));
        }
        if (!any.empty()) parts.push_back(anyOf(std::move(any)));
        for (const auto& inner : selection.negated) {
            auto part = make(inner, step);
            MOTE_RETURN_IF_ERROR(part, "not");
            parts.push_back(noneOf(*std::move(part)));
        }
        return allOf(std::move(parts));
    }

    /// The conditions of the selection itself, those first that cost least.
    Status addOwn(const Selection& selection, const StepNumbers& step, PointConditions& parts) {
        if (selection.nothing) parts.push_back(noPoints());
        if (selection.density) parts.push_back(densityCondition(*selection.density, *step.points));
        const auto add = [&](MadeCondition made) -> Status {
            MOTE_RETURN_IF_ERROR(made);
            parts.push_back(*std::move(made));
            return success();
        };
        if (!selection.ids.empty()) MOTE_RETURN_IF_ERROR(add(ofIds(selection, step)), "ids");
        for (std::size_t i = 0; i < selection.ranges.size(); ++i) {
            const auto field = fmt::format("ranges[{}]", i);
            MOTE_RETURN_IF_ERROR(needColumns(step, false), field);
            MOTE_RETURN_IF_ERROR(add(rangeCondition(selection.ranges[i], step)), field);
        }
        if (selection.polygon) {
            MOTE_RETURN_IF_ERROR(needColumns(step, false), "polygon");
            MOTE_RETURN_IF_ERROR(add(polygonCondition(*selection.polygon, step)), "polygon");
        }
        if (selection.outermost)
            MOTE_RETURN_IF_ERROR(add(outermost(*selection.outermost, step)), "outermost");
        if (selection.lasso && step.points->pointCount() > 0)
            parts.push_back(lassoCondition(*selection.lasso, *step.points));
        return success();
    }

    MadeCondition outermost(const Selection::Outermost& wanted, const StepNumbers& step) const {
        MOTE_RETURN_IF_ERROR(needColumns(step, false));
        const auto test = findOutermost(wanted, step, cancelled_);
        if (!test.ok() && test.error().code == ErrorCode::notFound) {
            const auto& error = test.error();  // at a column's name
            return Error{error.code, "plane", fmt::format("\"{}\" {}", error.where, error.message)};
        }
        MOTE_RETURN_IF_ERROR(test);
        return outermostCondition(wanted.plane, *test, step);
    }

    MadeCondition ofIds(const Selection& selection, const StepNumbers& step) const {
        MOTE_RETURN_IF_ERROR(needColumns(step, true));
        return inMask(pointsOf(IdSet(selection.ids), *step.columns, cancelled_));
    }

    /// Of a selection that was made in another step.
    MadeCondition sameIds(const Selection& selection, std::uint32_t made, std::uint32_t step) {
        for (const auto one : {made, step}) {
            MOTE_ASSIGN_OR_RETURN(const auto* const numbers, this->numbers(one));
            MOTE_RETURN_IF_ERROR(needColumns(*numbers, true), "step");
        }
        MOTE_ASSIGN_OR_RETURN(const auto mask, select(selection, made));
        const auto ids = IdSet::of(mask, *numbers_.at(made).columns, cancelled_);
        if (!ids) return wasCancelled();
        return inMask(pointsOf(*ids, *numbers_.at(step).columns, cancelled_));
    }

    static MadeCondition inMask(std::optional<PointMask> mask) {
        if (!mask) return wasCancelled();
        return maskCondition(*std::move(mask));
    }

    const RunSteps& run_;
    const std::function<bool()>& cancelled_;
    std::map<std::uint32_t, StepNumbers> numbers_;
};

}  // namespace

Result<PointMask> selectPoints(const Selection& selection, const RunSteps& run, std::uint32_t step,
                               const std::function<bool()>& cancelled) {
    try {
        return Selector(run, cancelled).select(selection, step);
    } catch (const StorageError& error) {
        return error.error();
    }
}

}  // namespace mote::storage
