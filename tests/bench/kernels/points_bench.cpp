// SPDX-License-Identifier: GPL-3.0-or-later
#include <benchmark/benchmark.h>

#include "server/render/cpu/cpu_device.h"
#include "server/render/cpu/points_kernel.h"
#include "server/render/layers/make_frame_plan.h"
#include "tests/bench/kernels/picture.h"
#include "tests/reference/scene_styles.h"

namespace mote::bench {
namespace {

/// The inner loop alone, on one thread: decode, transform, count.
void count(benchmark::State& state) {
    const auto scene = beamScene(Shown::points);
    const auto& step = *scene.layers[0].step;
    const auto plan = render::makeFramePlan(scene, render::Quality::exact());
    const auto& drawn = plan.points[0].selection->drawn;
    render::LeafCells cells;
    const auto places = cells.upTo(step, drawn.size());
    const auto points = step.positions(0, step.pointCount());
    const render::LeafRun run{.cells = places.data(),
                              .drawn = drawn.data(),
                              .count = step.leaves().pointCount.data(),
                              .points = points.data(),
                              .end = points.data() + points.size(),
                              .leaves = drawn.size()};
    const auto map = render::PointMap::make(plan, plan.points[0]);
    std::vector<std::uint32_t> counts(std::size_t{plan.width} * plan.height + render::spareCounts);
    for (auto _ : state)
        benchmark::DoNotOptimize(render::countPoints(map, run, render::neverFull, counts.data()));
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(points.size()));
}
BENCHMARK(count)->Name("points/count")->Unit(benchmark::kMillisecond);

/// Whole pictures, with all threads. Bigger points are discs; with a volume they are kept apart by depth.
void picture(benchmark::State& state, Shown shown, double size) {
    auto scene = beamScene(shown);
    test::particlesIn(scene).pointSize = size;
    render::CpuDevice device;
    const auto plan = render::makeFramePlan(scene, render::Quality::exact());
    for (auto _ : state) benchmark::DoNotOptimize(device.render(plan, render::PixelFormat::srgb8, {}));
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(plan.points[0].pointsDrawn));
}
BENCHMARK_CAPTURE(picture, pixel, Shown::points, 1.0)
    ->Name("points/picture")
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(picture, discs, Shown::points, 3.0)
    ->Name("points/picture/discs")
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(picture, hybrid, Shown::hybrid, 1.0)
    ->Name("points/picture/with_volume")
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace mote::bench
