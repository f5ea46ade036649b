// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/load_points.h"

#include <fmt/format.h>

#include <utility>

#include "server/log.h"
#include "server/render/layers/particles/point_data.h"
#include "server/render/layers/particles/usual_range.h"
#include "storage/numbers/dataset_steps.h"
#include "storage/numbers/select_points.h"
#include "storage/particles/mapped_step.h"

namespace mote::server {
namespace {

using storage::Catalogue;

// Estimates of what is held while something is loaded, in bytes. What is mapped as it is read is the kernel's
// to take back.
constexpr std::uint64_t perChosenPoint = sizeof(storage::PackedPosition) + sizeof(std::uint32_t) + 1;
constexpr std::uint64_t perLeaf = 200;  // with its share of the nodes, of the run and of the chosen
constexpr std::uint64_t perCell = sizeof(double) + sizeof(float);

Status checkStep(const Catalogue::Entry& entry, std::uint32_t step) {
    if (entry.manifest->kind() != "particles") {
        return Error{
            ErrorCode::invalidArgument, "dataset",
            fmt::format("\"{}\" is of kind \"{}\", not particles", entry.name, entry.manifest->kind())};
    }
    const auto steps = entry.manifest->particles().steps_size();
    if (step < static_cast<std::uint32_t>(steps)) return success();
    return Error{ErrorCode::notFound, "step", fmt::format("\"{}\" has {} steps", entry.name, steps)};
}

std::uint64_t pointsIn(const Catalogue::Entry& entry, std::uint32_t step) {
    return entry.manifest->particles().steps(static_cast<int>(step)).particles();
}

storage::DatasetSteps runOf(const Catalogue::Entry& entry) {
    return {entry.directory, entry.manifest};
}

/// At most what the whole step would take.
std::uint64_t chosenBytes(const Catalogue::Entry& entry, std::uint32_t step) {
    const auto& particles = entry.manifest->particles();
    const auto points = pointsIn(entry, step);
    const auto leaves = 4 * points / std::max(particles.leaf_capacity(), 1U) + 1;
    return points * perChosenPoint + leaves * perLeaf +
           perCell * (std::uint64_t{1} << (3 * particles.volume_level()));
}

}  // namespace

std::string keyOf(const Selection& selection) {
    return toProto(selection).SerializeAsString();
}

Result<Loadable<ChosenPoints>> chosenPoints(const Catalogue::Entry& entry, std::uint32_t step,
                                            const Selection& selection) {
    MOTE_RETURN_IF_ERROR(checkStep(entry, step));
    const auto load = [entry, selection](
                          std::uint32_t index,
                          const AnyLoadable::Cancelled& cancelled) -> Result<Loadable<ChosenPoints>::Value> {
        const auto run = runOf(entry);
        MOTE_ASSIGN_OR_RETURN(const auto mask, storage::selectPoints(selection, run, index, cancelled));
        auto chosen = std::make_shared<ChosenPoints>();
        if (mask.count() == mask.size()) return Loadable<ChosenPoints>::Value(std::move(chosen));
        MOTE_ASSIGN_OR_RETURN(const auto numbers, run.step(index));
        MOTE_ASSIGN_OR_RETURN(
            const auto some,
            storage::SelectedStep::make(*numbers.points, mask, run.manifest().leaf_capacity(), cancelled));
        numbers.points->check();
        if (const auto* const mapped = dynamic_cast<const storage::MappedStep*>(numbers.points.get()))
            some->origin = storage::SelectedStep::Origin{mapped->origin(), keyOf(selection)};
        chosen->step = some;
        return Loadable<ChosenPoints>::Value(std::move(chosen));
    };
    Loadable<ChosenPoints> loadable(
        entry, [entry](std::uint32_t index) { return chosenBytes(entry, index); }, load);
    loadable.key = keyOf(selection);
    loadable.step = step;
    loadable.steps = entry.manifest->particles().steps_size();
    return loadable;
}

Result<Loadable<render::PointValues>> valuesOf(const Catalogue::Entry& entry, std::uint32_t step,
                                               const std::string& column, const ValueRange& range,
                                               const std::shared_ptr<const ChosenPoints>& chosen,
                                               const std::string& selectionKey) {
    MOTE_RETURN_IF_ERROR(checkStep(entry, step));
    // What waits for its turn, or was given up, must not keep the points.
    const bool some = chosen != nullptr && chosen->step != nullptr;
    const auto load =
        [entry, column, range, some, points = std::weak_ptr(chosen)](
            std::uint32_t index,
            const AnyLoadable::Cancelled& cancelled) -> Result<Loadable<render::PointValues>::Value> {
        const auto held = points.lock();
        if (some && held == nullptr)
            return Error{ErrorCode::cancelled, "colorBy", "the selection has changed"};
        const auto run = runOf(entry);
        MOTE_ASSIGN_OR_RETURN(const auto numbers, run.step(index));
        if (some && held->step->pointCount() == 0) {
            return Loadable<render::PointValues>::Value(std::make_shared<render::PointValues>());
        }
        const auto sources = some ? held->step->sources() : std::span<const std::uint32_t>();
        return render::pointValues(numbers, column, range, sources, cancelled);
    };
    Loadable<render::PointValues> loadable(
        entry,
        [entry](std::uint32_t index) { return 2 * pointsIn(entry, index) * sizeof(render::ValueCode); },
        load);
    loadable.key = fmt::format("{} {:a} {:a} {}", column, range.low, range.high, selectionKey);
    loadable.step = step;
    // Of a selection, the points of later steps are not known yet.
    loadable.steps = some ? 1 : entry.manifest->particles().steps_size();
    return loadable;
}

Result<Loadable<KnownRange>> rangeOf(const Catalogue::Entry& entry, const std::string& column) {
    MOTE_RETURN_IF_ERROR(checkStep(entry, 0));
    const auto load = [entry, column](
                          std::uint32_t,
                          const AnyLoadable::Cancelled& cancelled) -> Result<Loadable<KnownRange>::Value> {
        MOTE_ASSIGN_OR_RETURN(const auto range, render::usualRange(runOf(entry), column, cancelled));
        return Loadable<KnownRange>::Value(std::make_shared<const KnownRange>(KnownRange{range}));
    };
    Loadable<KnownRange> loadable(
        entry, [](std::uint32_t) { return KnownRange::bytes() + render::RangeSample::bytes(); }, load);
    loadable.key = column;
    return loadable;
}

Result<Loadable<render::PointPaths>> pathsOf(const Catalogue::Entry& entry, const proto::Paths& paths) {
    MOTE_RETURN_IF_ERROR(checkStep(entry, 0));
    const std::vector<std::uint64_t> ids(paths.ids().begin(), paths.ids().end());
    const auto load = [entry, ids](std::uint32_t, const AnyLoadable::Cancelled& cancelled) {
        return render::pointPaths(runOf(entry), ids, cancelled);
    };
    const auto steps = static_cast<std::uint64_t>(entry.manifest->particles().steps_size());
    const auto bytes = 2 * ids.size() * (steps * sizeof(glm::dvec3) + sizeof(std::uint32_t));
    Loadable<render::PointPaths> loadable(
        entry, [bytes](std::uint32_t) { return bytes; }, load);
    for (const auto id : ids) loadable.key += fmt::format("{} ", id);
    return loadable;
}

Result<Loadable<render::StepWays>> waysBetween(const Catalogue::Entry& entry, std::uint32_t first,
                                               std::uint32_t second) {
    MOTE_RETURN_IF_ERROR(checkStep(entry, first));
    MOTE_RETURN_IF_ERROR(checkStep(entry, second));
    const auto load = [entry, second](std::uint32_t step, const AnyLoadable::Cancelled& cancelled)
        -> Result<Loadable<render::StepWays>::Value> {
        MOTE_ASSIGN_OR_RETURN(auto ways, render::stepWays(runOf(entry), step, second, cancelled));
        if (ways->moving == 0) {
            log::info("{}: views between steps {} and {} dissolve: {}", entry.name, step, second,
                      ways->swung ? "particles swing too far from one to the other to tell how they went"
                                  : "no id is that of one particle in both");
        }
        return ways;
    };
    Loadable<render::StepWays> loadable(
        entry,
        [entry, second](std::uint32_t step) {
            return render::StepWays::bytesAPoint * (pointsIn(entry, step) + pointsIn(entry, second));
        },
        load);
    loadable.key = fmt::format("to {}", second);
    loadable.step = first;
    return loadable;
}

}  // namespace mote::server
