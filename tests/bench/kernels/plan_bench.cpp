// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/make_frame_plan.h"

#include <benchmark/benchmark.h>

#include "tests/bench/kernels/picture.h"

namespace mote::bench {
namespace {

/// The first plan of a style.
void firstPlan(benchmark::State& state) {
    const auto scene = beamScene(Shown::points);
    for (auto _ : state) benchmark::DoNotOptimize(render::makeFramePlan(scene, render::Quality::exact()));
    state.SetItemsProcessed(state.iterations() *
                            static_cast<std::int64_t>(scene.layers[0].step->leaves().size()));
}
BENCHMARK(firstPlan)->Name("plan/first")->Unit(benchmark::kMicrosecond);

/// One after it, from another eye; `near`: so close that a part of the leaves is out of view.
void nextPlan(benchmark::State& state, double share) {
    auto scene = beamScene(Shown::points);
    scene.view.camera.eye *= share;
    render::SelectionCache selections;
    const auto eyes = orbitOf(scene.view.camera, 36);
    std::size_t at = 0;
    for (auto _ : state) {
        scene.view.camera.eye = eyes[at++ % eyes.size()];
        benchmark::DoNotOptimize(
            render::makeFramePlan(scene, render::Quality::exact(), selections, {.preview = true}));
    }
}
BENCHMARK_CAPTURE(nextPlan, framed, 1.0)->Name("plan/next/framed")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(nextPlan, near, 0.2)->Name("plan/next/near")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace mote::bench
