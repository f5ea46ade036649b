// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/seen_fields.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

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
        if (number != GridBricks::none) range = bricks->rangeOf(static_cast<std::size_t>(number));
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

SeenFields::Resident& SeenFields::resident(const std::shared_ptr<const void>& data, bool corrected,
                                           bool mixed, const std::function<BlockRanges()>& ranges) {
    // New data may stand at the address of some that are gone: the weak pointers tell them apart.
    auto known = std::find_if(fields_.begin(), fields_.end(), [&](const Resident& one) {
        return one.key == data.get() && one.corrected == corrected && one.mixed == mixed &&
               !one.data.expired();
    });
    if (known == fields_.end())
        known = fields_.insert(known, Resident{data, data.get(), corrected, mixed, ranges(), {}});
    return *known;
}

SeenField SeenFields::of(const FieldPlan& plan, const CorrectedField& samples) {
    const TransferTable& table = tables_.of(plan.transfer);
    if (!plan.transfer.visible()) return {&table, nullptr, nullptr};
    Resident& known =
        resident(samples.grid, samples.corrected(), samples.mixed(), [&] { return gridRanges(samples); });
    const Visible& visible = mostRecent(
        known.visible, kept, [&](const Visible& one) { return one.opacity == plan.transfer.opacity; },
        [&] {
            return Visible{plan.transfer.opacity, VisibleBlocks(known.ranges, table)};
        });
    if (!visible.blocks.any()) return {&table, nullptr, nullptr};
    return {&table, &visible.blocks, &known.ranges, samples.gradient > 0.0 ? slopesOf(samples) : nullptr};
}

std::shared_ptr<const GridSlopes> SeenFields::slopesOf(const CorrectedField& samples) {
    const GridField& field = *samples.grid;
    const bool corrected = samples.corrected();
    return slopes_.of(samples.grid, corrected, kept, gridSlopesBytes(field, corrected),
                      [&] { return gridSlopes(field, corrected); });
}

SeenField SeenFields::of(const FieldPlan& plan, const DensityField& samples,
                         const std::function<BlockRanges()>& ranges) {
    const TransferTable& table = tables_.of(colorsOf(plan.transfer));
    Resident& known = resident(samples.grid, false, false, ranges);
    const auto seen = [](const BlockRanges::Range& range) { return range.high > 0.0F; };
    if (known.visible.empty())
        known.visible.push_back({plan.transfer.opacity, VisibleBlocks(known.ranges, seen)});
    const VisibleBlocks& blocks = known.visible.front().blocks;
    if (!blocks.any()) return {&table, nullptr, nullptr};
    return {&table, &blocks, &known.ranges};
}

void SeenFields::dropExpired() {
    fields_.remove_if([](const Resident& one) { return one.data.expired(); });
    slopes_.dropExpired();
}

}  // namespace mote::render
