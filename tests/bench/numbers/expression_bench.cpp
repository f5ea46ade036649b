// SPDX-License-Identifier: GPL-3.0-or-later
//
// bench-expression [ROWS [THREADS]]: expressions over columns in memory, best of two;
// expression_numpy.py has the same by one thread of numpy (docs/PERFORMANCE.md).
#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>

#include <chrono>
#include <cstdlib>
#include <ctime>
#include <optional>
#include <random>

#include "protocol/quantity/expression.h"

namespace {

constexpr std::size_t block = 8192;
constexpr int runs = 2;

std::vector<double> anyColumn(std::size_t rows, std::uint64_t seed, double middle, double width) {
    std::vector<double> column(rows);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rows, std::size_t{1} << 20), [&](const auto& range) {
        std::mt19937_64 random(seed + range.begin());
        for (auto i = range.begin(); i < range.end(); ++i)
            column[i] = middle + width * (static_cast<double>(random() >> 11) * 0x1p-53 - 0.5);
    });
    return column;
}

/// On the clock, and of processors, of all threads together.
struct Seconds {
    double clock = 1e9, processor = 1e9;
};

Seconds secondsOf(const mote::Expression& expression, std::span<const std::span<const double>> columns,
                  std::vector<double>& out) {
    const auto begun = std::chrono::steady_clock::now();
    const auto used = std::clock();
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, out.size(), block), [&](const auto& range) {
        mote::Expression::Scratch scratch;
        std::vector<std::span<const double>> parts;
        for (auto begin = range.begin(); begin < range.end(); begin += block) {
            const auto count = std::min(block, range.end() - begin);
            parts.clear();
            for (const auto& column : columns) parts.push_back(column.subspan(begin, count));
            expression.evaluate(parts, scratch, std::span(out).subspan(begin, count));
        }
    });
    return {std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count(),
            static_cast<double>(std::clock() - used) / CLOCKS_PER_SEC};
}

}  // namespace

int main(int argc, char** argv) {
    const std::size_t rows = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 10'000'000;
    const auto threads = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 0;
    std::optional<tbb::global_control> limit;
    if (threads > 0) limit.emplace(tbb::global_control::max_allowed_parallelism, threads);
    const std::vector<std::pair<std::string, std::vector<double>>> all{{"x", anyColumn(rows, 1, 0.0, 2e-3)},
                                                                       {"y", anyColumn(rows, 2, 0.0, 2e-3)},
                                                                       {"px", anyColumn(rows, 3, 0.0, 1e4)},
                                                                       {"pz", anyColumn(rows, 4, 5e6, 1e4)}};
    std::vector<double> out(rows);
    for (const auto* text : {"hypot(x,y)", "pz*1e-9", "sqrt(x^2+y^2)/pz", "(x*px+y*y)/(x^2+y^2)-pz*1e-9",
                             "where(x>0 and y<0,hypot(x,y),px/pz)", "atan2(y,x)", "exp(-x^2)*sin(y)"}) {
        const auto expression = mote::Expression::parse(text);
        std::vector<std::span<const double>> columns;
        for (const auto& name : expression->names()) {
            for (const auto& [own, column] : all) {
                if (own == name.text) columns.emplace_back(column);
            }
        }
        Seconds best;
        for (int run = 0; run < runs; ++run) {
            const auto [clock, processor] = secondsOf(*expression, columns, out);
            best = {std::min(best.clock, clock), std::min(best.processor, processor)};
        }
        fmt::print("{:<40} {:8.1f} ms, {:8.1f} ms of processors\n", text, best.clock * 1e3,
                   best.processor * 1e3);
    }
    return 0;
}
