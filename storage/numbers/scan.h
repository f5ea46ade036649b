// SPDX-License-Identifier: GPL-3.0-or-later
//
// How functions go through the points of a step: in blocks whose borders do not depend on the number of
// threads, each of whole words of a PointMask. Functions without state.
#pragma once

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdint>
#include <functional>
#include <span>

#include "storage/numbers/point_mask.h"
#include "storage/particles/particle_step.h"
#include "storage/storage_error.h"

namespace mote::storage {

inline constexpr std::uint64_t blockPoints = 8192;
/// Between two questions whether to stop, where nothing is done in blocks.
inline constexpr std::uint64_t askedEach = 4096;

inline std::uint64_t blockCount(std::uint64_t points) {
    return (points + blockPoints - 1) / blockPoints;
}
inline PointRange pointsOfBlock(std::uint64_t block, std::uint64_t points) {
    const auto begin = block * blockPoints;
    return {begin, std::min(blockPoints, points - begin)};
}
inline std::size_t wordCount(std::uint64_t points) {
    return static_cast<std::size_t>((points + PointMask::wordBits - 1) / PointMask::wordBits);
}

inline bool anyChosen(std::span<const std::uint64_t> words) {
    return std::ranges::any_of(words, [](std::uint64_t word) { return word != 0; });
}
/// Calls `take` with the place of each bit that is set, ascending.
template <class Take>
void forEachChosen(std::span<const std::uint64_t> words, const Take& take) {
    for (std::size_t i = 0; i < words.size(); ++i) {
        for (auto word = words[i]; word != 0; word &= word - 1)
            take(i * PointMask::wordBits + static_cast<std::size_t>(std::countr_zero(word)));
    }
}

/// Calls `work` with each of so many blocks, on all threads of the calling arena; false where `cancelled`,
/// which is asked before each block on its thread, said to stop.
template <class Work>
bool forBlocks(std::uint64_t blocks, const std::function<bool()>& cancelled, const Work& work) {
    std::atomic<bool> stopped{false};
    tbb::parallel_for(tbb::blocked_range<std::uint64_t>(0, blocks),
                      [&](const tbb::blocked_range<std::uint64_t>& range) {
                          for (auto block = range.begin(); block != range.end(); ++block) {
                              if (stopped.load(std::memory_order_relaxed)) return;
                              if (cancelled && cancelled()) {
                                  stopped = true;
                                  return;
                              }
                              work(block);
                          }
                      });
    return !stopped;
}

}  // namespace mote::storage
