// SPDX-License-Identifier: GPL-3.0-or-later
//
// MOTE_ANY_VECTORS: a function made once for each width of vectors, with all that it calls. Sources that use
// it are compiled without contraction (CMakeLists.txt), so that all give the same bits. Sanitizers are not
// ready when the loader chooses one.
// MOTE_WIDEST_VECTORS: a function made for vectors of 64 bytes, to be called if hasWidestVectors(). Not
// defined where there can be none.
#pragma once

#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__) || defined(__clang__) || \
    !defined(__x86_64__)
#define MOTE_ANY_VECTORS
#else
#define MOTE_ANY_VECTORS __attribute__((flatten, target_clones("avx512f", "avx2", "default")))
#define MOTE_WIDEST_VECTORS __attribute__((flatten, target("avx512f")))
inline bool hasWidestVectors() {
    return __builtin_cpu_supports("avx512f") != 0;
}
#endif
