// SPDX-License-Identifier: GPL-3.0-or-later
#include <benchmark/benchmark.h>

#include <span>
#include <vector>

#include "storage/hash.h"

namespace mote::bench {
namespace {

constexpr std::size_t size = std::size_t{64} << 20;

/// One XXH3-64 a MiB, as datasets are verified when they are read.
void hashBlocks(benchmark::State& state) {
    const std::vector<std::byte> bytes(size, std::byte{7});
    for (auto _ : state) {
        for (std::size_t at = 0; at < size; at += storage::blockBytes) {
            benchmark::DoNotOptimize(storage::hashBlock(std::span(bytes).subspan(at, storage::blockBytes)));
        }
    }
    state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(size));
}
BENCHMARK(hashBlocks)->Name("hash/blocks")->Unit(benchmark::kMillisecond);

void hashFile(benchmark::State& state) {
    const std::vector<std::byte> bytes(size, std::byte{7});
    for (auto _ : state) benchmark::DoNotOptimize(storage::hash128(bytes));
    state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(size));
}
BENCHMARK(hashFile)->Name("hash/file")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace mote::bench
