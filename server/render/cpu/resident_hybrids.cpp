// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/resident_hybrids.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "server/render/plan/latest.h"

namespace mote::render {
namespace {

constexpr std::uint32_t edgeBits = 3, edge = 1U << edgeBits;
static_assert(edge == HybridBricks::edge, "a block is a brick");

/// Of the low volume's samples around the places from `first` to `last`, in its samples.
CodeRange rangeOf(const HybridGrid& low, const glm::dvec3& first, const glm::dvec3& last) {
    const glm::dvec3 most = glm::dvec3(low.size) - 1.0;
    const glm::uvec3 from(glm::clamp(glm::floor(first), glm::dvec3(0.0), most));
    const glm::uvec3 to(glm::clamp(glm::ceil(last), glm::dvec3(0.0), most));
    CodeRange range;
    for (std::uint32_t z = from.z; z <= to.z; ++z) {
        for (std::uint32_t y = from.y; y <= to.y; ++y) {
            for (std::uint32_t x = from.x; x <= to.x; ++x) range.add(low.values[low.index({x, y, z})]);
        }
    }
    return range;
}

CodeRange rangeOf(const HybridBricks& bricks, std::int32_t number) {
    CodeRange range;
    const auto begin = bricks.values.begin() + static_cast<std::ptrdiff_t>(number) * HybridBricks::volume;
    std::for_each(begin, begin + HybridBricks::volume, [&](std::uint16_t code) { range.add(code); });
    return range;
}

}  // namespace

BlockRanges hybridRanges(const HybridStep& step, bool corrected, bool mixed) {
    const HybridBricks* const bricks = corrected ? step.bricks.get() : nullptr;
    const glm::uvec3 cells = bricks != nullptr ? bricks->size : step.low.size;
    const glm::uvec3 count = (cells + (edge - 1U)) / edge;
    const glm::dvec3 scale = glm::dvec3(step.low.size) / glm::dvec3(cells);
    std::vector<BlockRanges::Range> ranges(std::size_t{count.x} * count.y * count.z);
    std::vector<std::uint8_t> fine(ranges.size(), bricks != nullptr ? 0 : 1);
    tbb::parallel_for(std::size_t{0}, ranges.size(), [&](std::size_t i) {
        const glm::dvec3 first(edge * glm::uvec3(i % count.x, i / count.x % count.y, i / count.x / count.y));
        const std::int32_t number = bricks != nullptr ? bricks->numbers[i] : HybridBricks::none;
        CodeRange range;
        if (number != HybridBricks::none) range = rangeOf(*bricks, number);
        if (number == HybridBricks::none || mixed) {
            // A block also has what lies before the first sample, and a hair more, as rays are in single
            // precision.
            const CodeRange low =
                rangeOf(step.low, (first + 0.49) * scale - 0.5, (first + (edge + 0.51)) * scale - 0.5);
            range.add(low.low);
            range.add(low.high);
        }
        if (number != HybridBricks::none) fine[i] = 1;
        ranges[i] = {static_cast<float>(step.valueOf(range.low)),
                     static_cast<float>(step.valueOf(range.high))};
    });
    return {edgeBits, count, std::move(ranges), std::move(fine)};
}

VisibleHybrid ResidentHybrids::of(const HybridPlan& plan) {
    const VolumeTable& transfer = table(plan.transfer);
    if (!(plan.transfer.opacity().maximum() > 0.0)) return {&transfer, nullptr, nullptr};
    Resident& kin = resident(plan);
    const Visible& visible = latest(
        kin.visible, kept,
        [&](const Visible& one) { return one.transfer.opacity() == plan.transfer.opacity(); },
        [&] {
            return Visible{plan.transfer, VisibleBlocks(kin.ranges, transfer)};
        });
    if (!visible.blocks.any()) return {&transfer, nullptr, nullptr};
    return {&transfer, &visible.blocks, &kin.ranges};
}

void ResidentHybrids::dropExpired() {
    volumes_.remove_if([](const Resident& one) { return one.step.expired(); });
}

const VolumeTable& ResidentHybrids::table(const HybridTransfer& transfer) {
    return latest(
               tables_, kept, [&](const Table& one) { return one.transfer == transfer; },
               [&] {
                   return Table{transfer, VolumeTable(
                                              transfer.span().low, transfer.span().high,
                                              [&](double value) { return transfer.extinction(value); },
                                              [&](double value) { return transfer.color(value); })};
               })
        .table;
}

ResidentHybrids::Resident& ResidentHybrids::resident(const HybridPlan& plan) {
    const bool corrected = plan.corrected(), mixed = plan.mixed();
    // A new step may stand at the address of one that is gone: the weak pointers tell them apart.
    for (auto& one : volumes_) {
        if (one.key == plan.step.get() && one.corrected == corrected && one.mixed == mixed &&
            !one.step.expired())
            return one;
    }
    return volumes_.emplace_back(Resident{
        plan.step, plan.step.get(), corrected, mixed, hybridRanges(*plan.step, corrected, mixed), {}});
}

}  // namespace mote::render
