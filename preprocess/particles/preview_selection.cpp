// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/preview_selection.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "preprocess/particles/cell_plan.h"
#include "protocol/base/mote_check.h"
#include "protocol/scene/drawn_points.h"

namespace mote::prep {
namespace {

using storage::Preview;

std::uint32_t drawnOf(const Octree& octree, std::size_t leaf, double fraction) {
    const auto cell = octree.leafCell[leaf];
    return drawnPoints(fraction, octree.leafPointCount[leaf], levelOf(cell), mortonOf(cell));
}

/// The one of `count` parts of [0, 1] that holds `at`; what lies outside is in the nearest.
std::size_t partOf(double at, std::size_t count) {
    return static_cast<std::size_t>(
        std::clamp(at * static_cast<double>(count), 0.0, static_cast<double>(count - 1)));
}

/// A stable sort by fraction of what is spread about evenly, by buckets; `place`, within [0, 1], does not
/// fall with the fraction.
template <class Place>
void sortEven(std::span<PreviewCandidate> candidates, const Place& place) {
    constexpr std::size_t few = 24;  // as many are in order sooner by insertion
    const auto less = [](const auto& a, const auto& b) { return a.from < b.from; };
    const std::size_t size = candidates.size();
    const std::vector<PreviewCandidate> all(candidates.begin(), candidates.end());
    std::vector<std::uint32_t> next(size + 1);
    for (const auto& one : all) ++next[partOf(place(one), size) + 1];
    std::partial_sum(next.begin(), next.end(), next.begin());
    for (const auto& one : all) candidates[next[partOf(place(one), size)]++] = one;
    // Buckets follow one another, so what is not in order is in one of them.
    for (std::size_t begin = 0, bucket = 0; bucket < size; begin = next[bucket++]) {
        const auto of = candidates.subspan(begin, next[bucket] - begin);
        if (of.size() > few) {
            std::stable_sort(of.begin(), of.end(), less);
            continue;
        }
        for (std::size_t i = 1; i < of.size(); ++i) {
            const auto after =
                std::upper_bound(of.begin(), of.begin() + static_cast<std::ptrdiff_t>(i), of[i], less);
            std::rotate(after, of.begin() + static_cast<std::ptrdiff_t>(i),
                        of.begin() + static_cast<std::ptrdiff_t>(i) + 1);
        }
    }
}

}  // namespace

std::uint64_t previewSize(std::uint64_t points) {
    return std::min<std::uint64_t>(points / 4, Preview::mostPoints);
}

PreviewSelection::PreviewSelection(const Octree& octree)
    : octree_(octree), total_(previewSize(octree.count.front())) {
    const auto& densities = octree.leafDensities;
    if (total_ > 0 && !densities.empty()) scale_ = {densities.min, densities.max};
}

Result<PreviewSelection> PreviewSelection::make(const Octree& octree, Communicator& ranks) {
    PreviewSelection selection(octree);
    if (selection.total_ > 0) MOTE_RETURN_IF_ERROR(selection.findFraction(ranks));
    return selection;
}

/// A fraction that draws at least the whole preview, and few points more.
Status PreviewSelection::findFraction(Communicator& ranks) {
    fraction_ = static_cast<double>(total_) / static_cast<double>(octree_.count.front());
    // The drawn points are as many as wanted but for chance; a fraction of 1 draws all.
    while (fraction_ < 1.0) {
        const std::uint64_t mine = drawnBy(fraction_);
        MOTE_ASSIGN_OR_RETURN(const auto drawn, shareValues<std::uint64_t>(ranks, std::span(&mine, 1)));
        std::uint64_t sum = 0;
        for (const auto& of : drawn) sum += of.front();
        if (sum >= total_) break;
        fraction_ *= 1.01;
    }
    // A little more, so that no point is lost to the rounding of drawnPoints.
    fraction_ = std::min(1.0, fraction_ * (1.0 + 1e-9));
    return success();
}

/// How many of this rank's points a fraction draws.
std::uint64_t PreviewSelection::drawnBy(double fraction) const {
    return tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, octree_.leafNode.size(), 1 << 14), std::uint64_t{0},
        [&](const tbb::blocked_range<std::size_t>& part, std::uint64_t count) {
            for (auto leaf = part.begin(); leaf < part.end(); ++leaf)
                count += drawnOf(octree_, leaf, fraction);
            return count;
        },
        std::plus<>());
}

void PreviewSelection::add(std::size_t leaf, std::uint32_t first,
                           std::span<const storage::PackedPosition> positions,
                           std::vector<PreviewCandidate>& candidates) const {
    if (total_ == 0) return;
    const auto drawn = drawnOf(octree_, leaf, fraction_);
    if (drawn <= first) return;
    const auto code = octree_.leafCell[leaf];
    const unsigned level = levelOf(code);
    const double offset = leafOffset(levelOf(code), mortonOf(code));
    const auto cell = mortonCell(mortonOf(code));
    const double density = octree_.leafDensity[leaf];
    const double t = density > 0.0 ? scale_.ofLeaf(density) : 0.0;
    const auto shade = static_cast<std::uint16_t>(std::lround(65535.0 * t));
    const auto place = [&](std::size_t axis, std::uint16_t within) {
        return static_cast<std::uint16_t>(((std::uint64_t{cell[axis]} << 16) | within) >> level);
    };
    for (std::size_t i = 0; i < std::min<std::size_t>(drawn - first, positions.size()); ++i) {
        const auto& at = positions[i];
        candidates.push_back(
            {drawnFrom(static_cast<std::uint32_t>(first + i), octree_.leafPointCount[leaf], offset),
             {place(0, at.x), place(1, at.y), place(2, at.z), shade}});
    }
}

std::size_t PreviewSelection::sliceOf(const PreviewCandidate& candidate, std::size_t slices) const {
    return partOf(candidate.from / fraction_, slices);
}

/// Fractions are spread evenly, so each of many parts is small, and each bucket of a part smaller.
void PreviewSelection::sort(const std::vector<std::span<const PreviewCandidate>>& lists, std::size_t first,
                            std::size_t last, std::size_t slices, std::span<PreviewCandidate> sorted) const {
    const std::size_t parts = sorted.size() / 1024 + 1;
    const double width = static_cast<double>(last - first);
    const auto at = [&](const PreviewCandidate& candidate) {
        const double slice = candidate.from / fraction_ * static_cast<double>(slices);
        return (slice - static_cast<double>(first)) / width;
    };
    std::vector<std::size_t> next(parts + 1);
    for (const auto& list : lists) {
        for (const auto& candidate : list) ++next[partOf(at(candidate), parts) + 1];
    }
    std::partial_sum(next.begin(), next.end(), next.begin());
    const auto begin = next;
    MOTE_CHECK(begin.back() == sorted.size());
    for (const auto& list : lists) {
        for (const auto& candidate : list) sorted[next[partOf(at(candidate), parts)]++] = candidate;
    }
    tbb::parallel_for(std::size_t{0}, parts, [&](std::size_t i) {
        const auto part = sorted.subspan(begin[i], begin[i + 1] - begin[i]);
        sortEven(part, [&](const PreviewCandidate& candidate) {
            return at(candidate) * static_cast<double>(parts) - static_cast<double>(i);
        });
    });
}

BuiltPreview PreviewSelection::preview(std::span<const PreviewCandidate> sorted, std::uint64_t before) const {
    BuiltPreview preview;
    preview.first = std::min(before, total_);
    const auto count = std::min<std::uint64_t>(sorted.size(), total_ - preview.first);
    preview.points.reserve(count);
    for (const auto& candidate : sorted.first(count)) {
        if ((preview.first + preview.points.size()) % Preview::blockPoints == 0) {
            preview.threshold.push_back(static_cast<float>(candidate.from));
        }
        preview.points.push_back(candidate.point);
    }
    return preview;
}

}  // namespace mote::prep
