// SPDX-License-Identifier: GPL-3.0-or-later
//
// bench-bandwidth: how many bytes a second memory delivers to threads that do nothing but read: what no
// renderer can pass. Each thread streams through its share of a buffer far larger than the caches; the best
// of several passes counts, as one JSON object.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <barrier>
#include <chrono>
#include <cstdint>
#include <span>
#include <thread>
#include <vector>

#include "protocol/cli/command.h"

namespace mote::bench {
namespace {

constexpr std::size_t lanes = 32;  // of 8 bytes: enough sums side by side that adding does not wait

std::uint64_t sumOf(std::span<const std::uint64_t> words) {
    std::array<std::uint64_t, lanes> sums{};
    for (std::size_t i = 0; i + lanes <= words.size(); i += lanes) {
        for (std::size_t k = 0; k < lanes; ++k) sums[k] += words[i + k];
    }
    std::uint64_t sum = 0;
    for (const auto part : sums) sum += part;
    return sum;
}

/// Seconds of the quickest pass. Each thread writes its share itself, so that it lies in memory near to it.
double quickest(std::size_t bytes, unsigned threads, int passes) {
    const std::size_t share = bytes / sizeof(std::uint64_t) / threads;
    std::vector<std::unique_ptr<std::uint64_t[]>> shares(threads);
    std::vector<std::uint64_t> sums(threads);
    double best = 1e9;
    auto start = std::chrono::steady_clock::now();
    int pass = -1;
    const auto turn = [&]() noexcept {
        const auto now = std::chrono::steady_clock::now();
        if (pass++ >= 0) best = std::min(best, std::chrono::duration<double>(now - start).count());
        start = std::chrono::steady_clock::now();
    };
    std::barrier together(static_cast<std::ptrdiff_t>(threads), turn);
    const auto work = [&](unsigned thread) {
        shares[thread] = std::make_unique_for_overwrite<std::uint64_t[]>(share);
        std::fill_n(shares[thread].get(), share, thread);
        for (int i = 0; i <= passes; ++i) {
            together.arrive_and_wait();
            if (i < passes) sums[thread] += sumOf({shares[thread].get(), share});
        }
    };
    {
        std::vector<std::jthread> workers;
        for (unsigned thread = 0; thread < threads; ++thread) workers.emplace_back(work, thread);
    }
    // Also keeps the compiler from leaving the reading out.
    for (unsigned thread = 0; thread < threads; ++thread) {
        const std::size_t read = share / lanes * lanes * static_cast<std::size_t>(passes);
        if (sums[thread] != thread * read) throw std::runtime_error("memory returned something else");
    }
    return best;
}

}  // namespace
}  // namespace mote::bench

int main(int argc, char** argv) {
    std::size_t mebibytes = 2048;
    unsigned threads = std::max(1U, std::thread::hardware_concurrency());
    int passes = 8;
    const mote::cli::Program commandLine("How fast memory is read, as one JSON object", "bench-bandwidth");
    const auto app = commandLine.command();
    app.option("--mebibytes", mebibytes, "size of the buffer").range(1, 1 << 20);
    app.option("--threads", threads, "default all").range(1, 1024);
    app.option("--passes", passes, "the quickest counts").range(1, 1000);
    if (const auto end = commandLine.parse(argc, argv)) return *end;
    const std::size_t bytes = mebibytes << 20;
    const double seconds = mote::bench::quickest(bytes, threads, passes);
    fmt::print(R"({{"bytesPerSecond": {:.6g}, "threads": {}, "mebibytes": {}}})"
               "\n",
               static_cast<double>(bytes) / seconds, threads, mebibytes);
}
