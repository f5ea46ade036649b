// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/encode.h"

#include <benchmark/benchmark.h>
#include <zstd.h>

#include <vector>

#include "protocol/wire/row_filter.h"
#include "tests/bench/kernels/picture.h"

namespace mote::bench {
namespace {

std::vector<std::uint8_t> filtered(const render::Picture& picture) {
    std::vector<std::uint8_t> rows(std::size_t{picture.width} * picture.height * 3);
    wire::filterRows(proto::SRGB8, picture.width, picture.pixels, rows);
    return rows;
}

void countPixels(benchmark::State& state, const render::Picture& picture) {
    state.SetItemsProcessed(state.iterations() * std::int64_t{picture.width} * picture.height);
}

void filter(benchmark::State& state) {
    const auto picture = pictureOf(Shown::points);
    std::vector<std::uint8_t> rows(std::size_t{picture.width} * picture.height * 3);
    for (auto _ : state) wire::filterRows(proto::SRGB8, picture.width, picture.pixels, rows);
    countPixels(state, picture);
}
BENCHMARK(filter)->Name("encode/row_filter")->Unit(benchmark::kMillisecond);

void unfilter(benchmark::State& state) {
    auto picture = pictureOf(Shown::points);
    const auto rows = filtered(picture);
    for (auto _ : state) wire::unfilterRows(proto::SRGB8, picture.width, rows, picture.pixels);
    countPixels(state, picture);
}
BENCHMARK(unfilter)->Name("encode/row_unfilter")->Unit(benchmark::kMillisecond);

/// zstd at level 1 on filtered rows, alone.
void compress(benchmark::State& state, Shown shown) {
    const auto picture = pictureOf(shown);
    const auto rows = filtered(picture);
    std::vector<std::uint8_t> packed(ZSTD_compressBound(rows.size()));
    std::size_t size = 0;
    for (auto _ : state) size = ZSTD_compress(packed.data(), packed.size(), rows.data(), rows.size(), 1);
    countPixels(state, picture);
    state.counters["KB"] = static_cast<double>(size) / 1e3;
}
BENCHMARK_CAPTURE(compress, points, Shown::points)->Name("encode/zstd/points")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(compress, hybrid, Shown::hybrid)->Name("encode/zstd/hybrid")->Unit(benchmark::kMillisecond);

void jpeg(benchmark::State& state, Shown shown) {
    const auto picture = pictureOf(shown);
    std::size_t size = 0;
    for (auto _ : state) size = server::encodeJpeg(picture).value().size();
    countPixels(state, picture);
    state.counters["KB"] = static_cast<double>(size) / 1e3;
}
BENCHMARK_CAPTURE(jpeg, points, Shown::points)->Name("encode/jpeg/points")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(jpeg, hybrid, Shown::hybrid)->Name("encode/jpeg/hybrid")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace mote::bench
