// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/volume_memory.h"

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
/// the errors, and the residuals of a slab.
std::uint64_t slabBytes(const VolumePlan& plan, std::uint64_t slices) {
    const double ratio = static_cast<double>(plan.source[2]) / plan.error[2];
    const auto ofSource = static_cast<std::uint64_t>(std::ceil(static_cast<double>(slices + 2) * ratio)) + 1;
    const std::uint64_t sourceSlice = std::uint64_t{plan.source[0]} * plan.source[1];
    const std::uint64_t errorSlice = std::uint64_t{plan.error[0]} * plan.error[1];
    return 4 * sourceSlice * std::max(ofSource, slices) + 12 * errorSlice * (slices + 2);
}

}  // namespace

Result<VolumeMemory> planMemory(const VolumePlan& plan, std::uint64_t limit) {
    const std::uint64_t all = memoryFor(limit);
    const std::uint64_t perSample = (plan.filter == LowFilter::under ? 8 : 4) + plan.valueBits / 8 + 1;
    const std::uint64_t base = fixed + perSample * storage::samplesOf(plan.low);
    VolumeMemory memory;
    // As many slices as help, a divisor of a brick of points; the larger half is for what is found.
    memory.slices = storage::pointBrickSide;
    while (memory.slices > storage::residualBrickSide && base + 2 * slabBytes(plan, memory.slices) > all) {
        memory.slices /= 2;
    }
    const auto needed = base + slabBytes(plan, memory.slices);
    if (needed <= all) {
        memory.results = all - needed;
        return memory;
    }
    return Error{
        ErrorCode::resourceExhausted, "",
        fmt::format("a volume of {} x {} x {} samples needs at least {} MiB of memory where the job may take "
                    "{} MiB",
                    plan.source[0], plan.source[1], plan.source[2], (needed >> 20) + 1, all >> 20)};
}

}  // namespace mote::prep
