// SPDX-License-Identifier: GPL-3.0-or-later
//
// What questions for numbers cost, without a server: bench-numbers DATASET.mote. Each line is the best of
// some runs on all threads, the columns in memory.
#include <fmt/format.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <glm/gtc/constants.hpp>

#include "protocol/scene/view_message.h"
#include "server/numbers/nearest_point.h"
#include "storage/manifest.h"
#include "storage/numbers/column_pieces.h"
#include "storage/numbers/dataset_steps.h"
#include "storage/numbers/histogram.h"
#include "storage/numbers/id_set.h"
#include "storage/numbers/point_statistics.h"
#include "storage/numbers/quantity_range.h"
#include "storage/numbers/select_points.h"
#include "tests/support/random.h"

namespace mote {
namespace {

using Clock = std::chrono::steady_clock;

[[noreturn]] void fail(const Error& error) {
    fmt::print(stderr, "bench-numbers: {}\n", error.toString());
    std::exit(1);
}

template <class T>
T need(Result<T> result) {
    if (!result.ok()) fail(result.error());
    return *std::move(result);
}

/// Milliseconds, the least of some runs after one that brings everything into memory.
double best(const std::function<void()>& work, int runs = 5) {
    double least = INFINITY;
    for (int i = 0; i <= runs; ++i) {
        const auto begun = Clock::now();
        work();
        const double took = std::chrono::duration<double, std::milli>(Clock::now() - begun).count();
        if (i > 0) least = std::min(least, took);
    }
    return least;
}

void line(const std::string& what, double ms) {
    fmt::print("{:<58} {:>10.1f} ms\n", what, ms);
}

/// The middle half of a column's range.
Selection::Range middle(const storage::RunSteps& run, const std::string& column) {
    const auto range = need(storage::quantityRange(run, column, {}));
    return {column, range.low + 0.25 * (range.high - range.low),
            range.high - 0.25 * (range.high - range.low)};
}

using storage::Passes;

void benchStep(const storage::RunSteps& run, std::uint32_t index) {
    const auto step = need(run.step(index));
    const auto points = step.points->pointCount();
    fmt::print("{} points, {} columns, {} threads\n", points, step.columns->columns().size(),
               tbb::this_task_arena::max_concurrency());
    Selection box;
    for (const auto* const column : {"x", "y", "z", "px", "py", "pz"})
        box.ranges.push_back(middle(run, column));
    storage::PointMask mask;
    line("select a box of six columns",
         best([&] { mask = need(storage::selectPoints(box, run, index, {})); }));
    storage::BeamFacts facts;
    facts.mass = run.manifest().mass();
    line(fmt::format("statistics of the {} in it", mask.count()),
         best(
             [&] {
                 need(storage::pointStatistics(step, facts, &mask, std::nullopt, Passes::percentilesToo, {}));
             },
             2));
    line("the same without percentiles",
         best(
             [&] {
                 need(storage::pointStatistics(step, facts, &mask, std::nullopt, Passes::momentsAlone, {}));
             },
             2));
    Selection small = box;
    for (auto& range : small.ranges) {
        const double center = 0.5 * (range.min + range.max), half = 0.1 * (range.max - range.min);
        range.min = center - half;
        range.max = center + half;
    }
    line("select a tenth as wide, and its statistics", best([&] {
             const auto few = need(storage::selectPoints(small, run, index, {}));
             need(storage::pointStatistics(step, facts, &few, std::nullopt, Passes::percentilesToo, {}));
         }));
    Selection polygon;
    polygon.polygon.emplace();
    polygon.polygon->first = "x";
    polygon.polygon->second = "px";
    const auto x = middle(run, "x"), px = middle(run, "px");
    for (int i = 0; i < 100000; ++i) {
        const double angle = glm::two_pi<double>() * i / 100000;
        polygon.polygon->points.emplace_back(0.5 * (x.min + x.max + (x.max - x.min) * std::cos(angle)),
                                             0.5 * (px.min + px.max + (px.max - px.min) * std::sin(angle)));
    }
    line("select by a polygon of 10^5 corners",
         best([&] { need(storage::selectPoints(polygon, run, index, {})); }));
    Selection outer;
    outer.outermost = {'x', 0.01};
    line("select the outermost 1%", best([&] { need(storage::selectPoints(outer, run, index, {})); }, 2));
    const std::vector<storage::HistogramAxis> axes{{"x", 512, 2 * x.min - x.max, 2 * x.max - x.min},
                                                   {"px", 512, 2 * px.min - px.max, 2 * px.max - px.min}};
    line("histogram 512 x 512", best([&] { need(storage::countHistogram(axes, false, step, nullptr, {})); }));
}

void benchPick(const storage::RunSteps& run, std::uint32_t index) {
    const auto step = need(run.step(index));
    proto::View message;
    message.set_width(1280);
    message.set_height(720);
    auto& layer = *message.add_layers();
    layer.set_dataset("data/run");
    layer.mutable_particles();
    const auto view = need(parseView(message));
    // Who picks has seen the points: their octree is in memory.
    const auto before = Clock::now();
    static_cast<void>(step.points->nodes());
    line("the octree into memory", std::chrono::duration<double, std::milli>(Clock::now() - before).count());
    test::Random random(1);
    std::vector<double> times;
    for (int i = 0; i < 200; ++i) {
        const server::PicturePlace place{random.between(300, 980), random.between(100, 620)};
        server::NearestPoint found;
        found.distance = 8.0;
        const auto begun = Clock::now();
        server::findNearest(*step.points, particlesStyleOf(*view.layers[0].particles()).pointFraction, view,
                            glm::dmat4(1.0), {}, place, {}, found);
        times.push_back(std::chrono::duration<double, std::milli>(Clock::now() - begun).count());
    }
    std::ranges::sort(times);
    line("pick, median of 200 places", times[100]);
    line("pick, the slowest of them", times.back());
}

void benchTrack(const storage::RunSteps& run) {
    const auto first = need(run.step(0));
    if (!first.columns->hasIds()) return;
    std::vector<std::uint64_t> ids;
    for (std::uint64_t i = 0; i < first.columns->pointCount(); i += 100)
        ids.push_back(first.columns->ids(i, 1)[0]);
    std::ranges::sort(ids);
    const std::vector<std::string> names{"id", "x", "px"};
    line(fmt::format("track {} ids through {} steps", ids.size(), run.manifest().steps_size()), best([&] {
             for (int step = 0; step < run.manifest().steps_size(); ++step) {
                 const auto numbers = need(run.step(static_cast<std::uint32_t>(step)));
                 need(need(storage::ColumnReader::make(numbers, names)).readIds(ids, {}));
             }
         }));
}

}  // namespace
}  // namespace mote

int main(int count, char** words) {
    if (count != 2) {
        fmt::print(stderr, "usage: bench-numbers DATASET.mote\n");
        return 2;
    }
    using namespace mote;
    const std::filesystem::path directory = words[1];
    const auto manifest = std::make_shared<const proto::Manifest>(need(storage::readManifest(directory)));
    if (!manifest->has_particles()) fail(unsupported(directory.string(), "is a dataset without particles"));
    if (manifest->particles().columns().empty()) fail(storage::withoutColumns(directory.string()));
    const storage::DatasetSteps run(directory, manifest);
    const auto last = static_cast<std::uint32_t>(run.manifest().steps_size() - 1);
    benchStep(run, last);
    benchPick(run, last);
    benchTrack(run);
}
