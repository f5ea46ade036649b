// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/hybrid/volume_memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "preprocess/machine_memory.h"

namespace mote::prep {
namespace {

constexpr std::uint64_t megabyte = std::uint64_t{1} << 20;
/// The program, its threads and what a source holds.
constexpr std::uint64_t fixed = 96 * megabyte;

/// An error pass holds the source's slices as floats, its samples on the error grid where that is another,
/// and the errors.
std::uint64_t slabBytes(const VolumePlan& plan, std::uint64_t slices) {
    const double ratio = static_cast<double>(plan.source[2]) / plan.error[2];
    const auto ofSource = static_cast<std::uint64_t>(std::ceil(static_cast<double>(slices + 2) * ratio)) + 1;
    const std::uint64_t sourceSlice = std::uint64_t{plan.source[0]} * plan.source[1];
    const std::uint64_t errorSlice = std::uint64_t{plan.error[0]} * plan.error[1];
    const std::uint64_t grids = plan.error == plan.source ? 1 : 2;
    return 4 * sourceSlice * std::max(ofSource, slices) + 4 * grids * errorSlice * (slices + 2);
}

/// Each thread collects the points of a row of bricks, 6 bytes each, in vectors that grow, and puts them
/// aside in one piece; residuals come in smaller parts.
std::uint64_t threadBytes(const VolumePlan& plan, std::uint64_t slices) {
    const std::uint64_t perSample = 18;
    return perSample * storage::pointBrickSide * plan.error[0] * slices;
}

/// The low-resolution volume as floats, a rank's share of it, its falls where it is lowered; its codes and
/// normals.
std::uint64_t lowBytes(const VolumePlan& plan) {
    const std::uint64_t perSample = (plan.filter == LowFilter::under ? 12 : 8) + plan.valueBits / 8 + 1;
    return perSample * storage::samplesOf(plan.low);
}

}  // namespace

Result<VolumeMemory> planMemory(const VolumePlan& plan, std::uint64_t limit, int threads) {
    const std::uint64_t all = memoryFor(limit);
    const auto needed = [&](std::uint32_t slices) {
        return fixed + lowBytes(plan) + slabBytes(plan, slices) +
               static_cast<std::uint64_t>(threads) * threadBytes(plan, slices);
    };
    // As many slices as help, a divisor of a brick of points.
    VolumeMemory memory{storage::pointBrickSide};
    while (memory.slices > storage::residualBrickSide && needed(memory.slices) > all) memory.slices /= 2;
    if (needed(memory.slices) <= all) return memory;
    return Error{
        ErrorCode::resourceExhausted, "",
        fmt::format("a volume of {} x {} x {} samples needs at least {} MiB of memory where the job may take "
                    "{} MiB",
                    plan.source[0], plan.source[1], plan.source[2], (needed(memory.slices) >> 20) + 1,
                    all >> 20)};
}

}  // namespace mote::prep
