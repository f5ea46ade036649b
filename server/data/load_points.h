// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is loaded of particles besides a step's points: those that a selection holds, values that colour them,
// the range of a quantity, the ways of some, those of all between two steps. Values; `entry` is one of the
// catalogue's. Errors: invalidArgument (a dataset of another kind), notFound (a step that is not there).
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "protocol/mote.pb.h"
#include "protocol/scene/selection.h"
#include "protocol/scene/transfer_function.h"
#include "server/data/loadable.h"
#include "server/render/layers/particles/point_paths.h"
#include "server/render/layers/particles/step_ways.h"
#include "server/render/plan/point_values.h"
#include "storage/particles/selected_step.h"

namespace mote::server {

/// The points of a step that a selection holds.
struct ChosenPoints {
    std::shared_ptr<const storage::SelectedStep> step;  ///< null: all of them, the step as it is

    std::uint64_t bytes() const { return step ? step->bytes() : 0; }
};

Result<Loadable<ChosenPoints>> chosenPoints(const storage::Catalogue::Entry& entry, std::uint32_t step,
                                            const Selection& selection);

/// The values of the points that are drawn: of `chosen`'s, the selection of the key, or null, of all.
Result<Loadable<render::PointValues>> valuesOf(const storage::Catalogue::Entry& entry, std::uint32_t step,
                                               const std::string& column, const ValueRange& range,
                                               const std::shared_ptr<const ChosenPoints>& chosen,
                                               const std::string& selectionKey);

/// What the colours of a column or derived quantity stand for if a view does not say it.
struct KnownRange {
    ValueRange range;
    static std::uint64_t bytes() { return sizeof(KnownRange); }
};

Result<Loadable<KnownRange>> rangeOf(const storage::Catalogue::Entry& entry, const std::string& column);

Result<Loadable<render::PointPaths>> pathsOf(const storage::Catalogue::Entry& entry,
                                             const proto::Paths& paths);

/// Of the points of two steps, `first` being the earlier one in the dataset.
Result<Loadable<render::StepWays>> waysBetween(const storage::Catalogue::Entry& entry, std::uint32_t first,
                                               std::uint32_t second);

/// What tells a selection from others.
std::string keyOf(const Selection& selection);

}  // namespace mote::server
