// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/grid_sights.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "protocol/scene/most_recent.h"

namespace mote::render {
namespace {

constexpr std::uint32_t edgeBits = 3, edge = 1U << edgeBits;
static_assert(edge == GridBricks::edge, "a block is a brick");

/// The range around the places from `first` to `last`, in samples.
CodeRange rangeOf(const SampleGrid& grid, const glm::dvec3& first, const glm::dvec3& last) {
    const glm::dvec3 most = glm::dvec3(grid.size) - 1.0;
    const glm::uvec3 from(glm::clamp(glm::floor(first), glm::dvec3(0.0), most));
    const glm::uvec3 to(glm::clamp(glm::ceil(last), glm::dvec3(0.0), most));
    CodeRange range;
    for (std::uint32_t z = from.z; z <= to.z; ++z) {
        for (std::uint32_t y = from.y; y <= to.y; ++y) {
            for (std::uint32_t x = from.x; x <= to.x; ++x) range.add(grid.values[grid.index({x, y, z})]);
        }
    }
    return range;
}

CodeRange rangeOf(const GridBricks& bricks, std::int32_t number) {
    CodeRange range;
    const auto begin = bricks.values.begin() + static_cast<std::ptrdiff_t>(number) * GridBricks::volume;
    std::for_each(begin, begin + GridBricks::volume, [&](std::uint16_t code) { range.add(code); });
    return range;
}

}  // namespace

BlockRanges gridRanges(const CorrectedField& field) {
    const GridField& grid = *field.grid;
    const GridBricks* const bricks = field.corrected() ? grid.bricks.get() : nullptr;
    const glm::uvec3 cells = bricks != nullptr ? bricks->size : grid.coarse.size;
    const glm::uvec3 count = (cells + (edge - 1U)) / edge;
    const glm::dvec3 scale = glm::dvec3(grid.coarse.size) / glm::dvec3(cells);
    std::vector<BlockRanges::Range> ranges(std::size_t{count.x} * count.y * count.z);
    std::vector<std::uint8_t> fine(ranges.size(), bricks != nullptr ? 0 : 1);
    tbb::parallel_for(std::size_t{0}, ranges.size(), [&](std::size_t i) {
        const glm::dvec3 first(edge * glm::uvec3(i % count.x, i / count.x % count.y, i / count.x / count.y));
        const std::int32_t number = bricks != nullptr ? bricks->numbers[i] : GridBricks::none;
        CodeRange range;
        if (number != GridBricks::none) range = rangeOf(*bricks, number);
        if (number == GridBricks::none || field.mixed()) {
            // A block also has what lies before the first sample, and a hair more, as rays are in single
            // precision.
            const CodeRange coarse =
                rangeOf(grid.coarse, (first + 0.49) * scale - 0.5, (first + (edge + 0.51)) * scale - 0.5);
            range.add(coarse.low);
            range.add(coarse.high);
        }
        if (number != GridBricks::none) fine[i] = 1;
        ranges[i] = {static_cast<float>(grid.valueOf(range.low)),
                     static_cast<float>(grid.valueOf(range.high))};
    });
    return {edgeBits, count, std::move(ranges), std::move(fine)};
}

const TransferTable& TransferTables::of(const TransferFunction& transfer) {
    constexpr std::size_t kept = 16;  // more than a picture has layers
    return mostRecent(
               entries_, kept, [&](const Entry& one) { return one.transfer == transfer; },
               [&] {
                   return Entry{transfer, TransferTable(transfer)};
               })
        .table;
}

GridSight GridSights::of(const FieldPlan& plan, const CorrectedField& samples) {
    const TransferTable& table = tables_.of(plan.transfer);
    if (!plan.transfer.visible()) return {&table, nullptr, nullptr};
    Resident& kin = resident(samples);
    const Visible& visible = mostRecent(
        kin.visible, kept, [&](const Visible& one) { return one.opacity == plan.transfer.opacity; },
        [&] {
            return Visible{plan.transfer.opacity, VisibleBlocks(kin.ranges, table)};
        });
    if (!visible.blocks.any()) return {&table, nullptr, nullptr};
    return {&table, &visible.blocks, &kin.ranges};
}

void GridSights::dropExpired() {
    fields_.remove_if([](const Resident& one) { return one.grid.expired(); });
}

GridSights::Resident& GridSights::resident(const CorrectedField& samples) {
    const bool corrected = samples.corrected(), mixed = samples.mixed();
    // A new field may stand at the address of one that is gone: the weak pointers tell them apart.
    for (auto& one : fields_) {
        if (one.key == samples.grid.get() && one.corrected == corrected && one.mixed == mixed &&
            !one.grid.expired())
            return one;
    }
    return fields_.emplace_back(
        Resident{samples.grid, samples.grid.get(), corrected, mixed, gridRanges(samples), {}});
}

}  // namespace mote::render
