// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/particles/point_data.h"

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "storage/beam/quantity_reader.h"
#include "storage/numbers/point_places.h"
#include "storage/numbers/scan.h"

namespace mote::render {
namespace {

using storage::QuantityReader;

Error noColumns() {
    return {
        ErrorCode::notFound, "",
        "the dataset was made without columns, so there are no numbers beside its points; making it again "
        "with mote-prep particles keeps them"};
}

Error noIds() {
    return {
        ErrorCode::notFound, "ids",
        "the dataset has no ids of particles, as its source has none, so particles cannot be followed from "
        "step to step"};
}

Result<QuantityReader> readerOf(const storage::StepNumbers& step, const std::string& column) {
    if (!step.columns) return noColumns();
    auto reader = QuantityReader::make(*step.columns, step.context, std::span(&column, 1));
    if (reader.ok()) return reader;
    const Error& error = reader.error();
    return Error{error.code, "column", "\"" + error.where + "\" " + error.message};
}

/// Calls take(block's first point, values) for all points of the step, on all threads; false if it was
/// told to stop.
template <class Take>
bool forValues(const storage::StepNumbers& step, const QuantityReader& reader, const Cancelled& cancelled,
               const Take& take) {
    struct Local {
        QuantityReader::Scratch scratch;
        std::vector<double> values;
    };
    tbb::enumerable_thread_specific<Local> locals;
    const auto points = step.points->pointCount();
    return storage::forBlocks(storage::blockCount(points), cancelled, [&](std::uint64_t block) {
        const auto part = storage::pointsOfBlock(block, points);
        Local& local = locals.local();
        local.values.resize(part.count);
        const std::array<std::span<double>, 1> out{local.values};
        reader.read(part.begin, part.count, local.scratch, out);
        take(part.begin, std::span<const double>(local.values));
    });
}

/// The first point that has an id.
std::optional<std::uint64_t> pointOf(std::uint64_t id, const storage::ParticleColumns& columns) {
    const auto idAt = [&](std::uint64_t rank) { return columns.ids(columns.pointOfRank(rank), 1).front(); };
    std::uint64_t first = 0, end = columns.pointCount();
    while (first < end) {
        const auto middle = first + (end - first) / 2;
        if (idAt(middle) < id)
            first = middle + 1;
        else
            end = middle;
    }
    if (first == columns.pointCount() || idAt(first) != id) return std::nullopt;
    return columns.pointOfRank(first);
}

std::shared_ptr<const PointValues> finished(std::shared_ptr<PointValues> values) {
    values->complete = std::ranges::find(values->codes, noValue) == values->codes.end();
    return values;
}

}  // namespace

Result<std::shared_ptr<const PointValues>> pointValues(const storage::StepNumbers& step,
                                                       const std::string& column, const ValueRange& range,
                                                       std::span<const std::uint32_t> points,
                                                       const Cancelled& cancelled) {
    MOTE_ASSIGN_OR_RETURN(const auto reader, readerOf(step, column));
    auto values = std::make_shared<PointValues>();
    values->codes.resize(step.points->pointCount());
    const auto take = [&](std::uint64_t begin, std::span<const double> block) {
        for (std::size_t i = 0; i < block.size(); ++i) values->codes[begin + i] = codeOf(block[i], range);
    };
    if (!forValues(step, reader, cancelled, take)) return wasCancelled();
    step.columns->check();
    if (points.empty()) return finished(std::move(values));
    auto some = std::make_shared<PointValues>();
    some->codes.reserve(points.size());
    for (const auto point : points) some->codes.push_back(values->codes.at(point));
    return finished(std::move(some));
}

Result<std::shared_ptr<const PointPaths>> pointPaths(const storage::RunSteps& run,
                                                     std::span<const std::uint64_t> ids,
                                                     const Cancelled& cancelled) {
    std::vector<std::vector<glm::dvec3>> ways(ids.size());
    for (int index = 0; index < run.manifest().steps_size(); ++index) {
        if (cancelled && cancelled()) return wasCancelled();
        MOTE_ASSIGN_OR_RETURN(const auto step, run.step(static_cast<std::uint32_t>(index)));
        if (!step.columns) return noColumns();
        if (!step.columns->hasIds()) return noIds();
        const storage::LeafWalk walk(*step.points);
        for (std::size_t i = 0; i < ids.size(); ++i) {
            const auto point = pointOf(ids[i], *step.columns);
            if (!point) continue;
            const auto cell = walk.cell(walk.leafOf(*point));
            ways[i].push_back(cell.at(step.points->positions(*point, 1).front()));
        }
        step.columns->check();
        step.points->check();
    }
    auto paths = std::make_shared<PointPaths>();
    for (const auto& way : ways) {
        paths->begin.push_back(static_cast<std::uint32_t>(paths->places.size()));
        paths->places.insert(paths->places.end(), way.begin(), way.end());
    }
    paths->begin.push_back(static_cast<std::uint32_t>(paths->places.size()));
    return std::shared_ptr<const PointPaths>(std::move(paths));
}

}  // namespace mote::render
