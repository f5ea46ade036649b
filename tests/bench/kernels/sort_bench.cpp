// SPDX-License-Identifier: GPL-3.0-or-later
#include <benchmark/benchmark.h>

#include <random>

#include "preprocess/particles/range_builder.h"

namespace mote::bench {
namespace {

std::vector<prep::Particle> beam(std::size_t count) {
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal(0.5, 0.08);
    const auto place = [&] {
        return static_cast<std::uint32_t>(4294967295.0 * std::clamp(normal(random), 0.0, 1.0));
    };
    std::vector<prep::Particle> particles(count);
    for (std::uint32_t row = 0; row < count; ++row) {
        const std::uint32_t x = place(), y = place(), z = place();
        particles[row] = {x, y, z, row};
    }
    return particles;
}

/// A range of the job on one thread: particles by Morton key, the octree of their cells, shuffled leaves.
void sortRange(benchmark::State& state) {
    const auto particles = beam(static_cast<std::size_t>(state.range(0)));
    const prep::PlanUnit all{.divided = true, .count = static_cast<std::uint32_t>(particles.size())};
    const prep::RangeOptions options{.octree = {.leafCapacity = 64, .maxLevel = 12}, .cellLevel = 6};
    prep::RangeBuilder builder;
    for (auto _ : state) benchmark::DoNotOptimize(builder.build(particles, {}, {&all, 1}, options));
    state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(sortRange)->Name("sort/range")->Arg(100'000)->Arg(1'000'000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace mote::bench
