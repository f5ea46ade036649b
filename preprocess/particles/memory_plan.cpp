// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/memory_plan.h"

#include <algorithm>

#include "preprocess/machine_memory.h"

namespace mote::prep {
namespace {

constexpr std::uint64_t megabyte = std::uint64_t{1} << 20;

}  // namespace

MemoryPlan planMemory(std::uint64_t particles, const StepOptions& options, std::uint64_t limit, int threads) {
    // Rounded up from measurements of 10^7 and 10^8 particles. Whatever their number: the program, the grid,
    // blocks on their way, the volume; then nodes and leaves, of which there are more the smaller the leaves,
    // on every rank.
    const std::uint64_t fixed = 96 * megabyte + static_cast<std::uint64_t>(threads) * 48 * megabyte;
    const std::uint64_t small = std::min(fixed, 4 * megabyte + 400 * particles);
    const std::uint64_t volume = std::uint64_t{12} << (3 * options.volumeLevel);
    const std::uint64_t tree = 300 * (particles / options.octree.leafCapacity + 1);
    const std::uint64_t preview = 32 * std::min<std::uint64_t>(particles / 4, storage::Preview::mostPoints);
    MemoryPlan plan;
    plan.needed = small + volume + tree + preview;
    const std::uint64_t all = memoryFor(limit);
    if (plan.needed > all) return plan;
    plan.kept = std::min(256 * megabyte, (all - plan.needed) / 8);
    plan.particles = all - plan.needed - plan.kept;
    return plan;
}

}  // namespace mote::prep
