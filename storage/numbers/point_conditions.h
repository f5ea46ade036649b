// SPDX-License-Identifier: GPL-3.0-or-later
//
// PointCondition: something that points of one step meet or not, asked of a block of them at once
// (storage/numbers/scan.h). A tree of conditions is a selection that was made ready for a step. Immutable;
// any number of threads, each with a Scratch of its own. What a condition reads must outlive it.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "protocol/scene/error.h"
#include "protocol/scene/selection.h"
#include "storage/beam/quantity_reader.h"
#include "storage/numbers/outermost.h"
#include "storage/numbers/point_mask.h"
#include "storage/numbers/run_steps.h"

namespace mote::storage {

class PointCondition {
  public:
    /// A thread's memory.
    struct Scratch {
        QuantityReader::Scratch reader;
        std::vector<double> first, second;
    };

    virtual ~PointCondition() = default;
    /// Takes the points out of `words`, a bit for each of the block from its first, that do not meet it.
    /// Throws StorageError.
    virtual void keep(PointRange block, std::span<std::uint64_t> words, Scratch& scratch) const = 0;
};

using PointConditions = std::vector<std::unique_ptr<const PointCondition>>;
using MadeCondition = Result<std::unique_ptr<const PointCondition>>;

/// Columns must be there for those that name some. Errors: notFound, at the field.
MadeCondition rangeCondition(const Selection::Range& range, const StepNumbers& step);
MadeCondition polygonCondition(const Selection::Polygon& polygon, const StepNumbers& step);
MadeCondition outermostCondition(char plane, const OutermostTest& test, const StepNumbers& step);

/// Throws StorageError.
std::unique_ptr<const PointCondition> densityCondition(const Selection::Density& density,
                                                       const ParticleStep& step);
std::unique_ptr<const PointCondition> lassoCondition(const Selection::Lasso& lasso, const ParticleStep& step);
std::unique_ptr<const PointCondition> maskCondition(PointMask mask);
/// That no point meets.
std::unique_ptr<const PointCondition> noPoints();

std::unique_ptr<const PointCondition> allOf(PointConditions parts);
std::unique_ptr<const PointCondition> anyOf(PointConditions parts);
std::unique_ptr<const PointCondition> noneOf(std::unique_ptr<const PointCondition> part);

}  // namespace mote::storage
