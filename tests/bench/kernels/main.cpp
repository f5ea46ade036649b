// SPDX-License-Identifier: GPL-3.0-or-later
//
// mote-bench: what the inner loops cost, one group a file. `mote-bench --benchmark_filter=points`.
#include <benchmark/benchmark.h>

BENCHMARK_MAIN();
