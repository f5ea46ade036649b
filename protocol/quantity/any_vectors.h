// SPDX-License-Identifier: GPL-3.0-or-later
//
// MOTE_ANY_VECTORS: a function made once for each width of vectors, with all that it calls. Sources that use
// it are compiled without contraction (CMakeLists.txt), so that all give the same bits. Sanitizers are not
// ready when the loader chooses one.
#pragma once

#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__) || defined(__clang__) || \
    !defined(__x86_64__)
#define MOTE_ANY_VECTORS
#else
#define MOTE_ANY_VECTORS __attribute__((flatten, target_clones("avx512f", "avx2", "default")))
#endif
