// SPDX-License-Identifier: GPL-3.0-or-later
#include <benchmark/benchmark.h>

#include "server/render/cpu/cpu_device.h"
#include "server/render/layers/make_frame_plan.h"
#include "tests/bench/device/bench_scene.h"

namespace mote::bench {
namespace {

/// Whole pictures of a ball of 128^3 cells, with all threads.
void picture(benchmark::State& state, bool filling, double samplesPerCell) {
    SceneOptions options;
    options.shown = Shown::volume;
    options.data = "ball:7";
    options.filling = filling;
    const auto scene = makeScene(options).value();
    render::Quality quality = render::Quality::exact();
    quality.samplesPerCell = samplesPerCell;
    render::CpuDevice device;
    const auto plan = render::makeFramePlan(scene, quality);
    device.render(plan, render::PixelFormat::srgb8, {});  // packs the volume
    for (auto _ : state) benchmark::DoNotOptimize(device.render(plan, render::PixelFormat::srgb8, {}));
}
BENCHMARK_CAPTURE(picture, framed, false, 1.0)
    ->Name("volume/framed/1")
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(picture, filling, true, 1.0)
    ->Name("volume/filling/1")
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(picture, exact, false, 4.0)
    ->Name("volume/framed/4")
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace mote::bench
