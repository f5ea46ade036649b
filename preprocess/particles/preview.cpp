// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/preview.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_reduce.h>
#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>

#include "preprocess/particles/morton.h"
#include "protocol/scene/drawn_points.h"

namespace mote::prep {
namespace {

using storage::Preview;
using storage::PreviewPoint;

constexpr std::size_t blockLeaves = std::size_t{1} << 14;

/// The density scale of the leaves that weigh anything.
LogDensity scaleOf(const storage::Leaves& leaves) {
    const auto first = std::upper_bound(leaves.density.begin(), leaves.density.end(), 0.0F);
    return first == leaves.density.end() ? LogDensity{} : LogDensity{*first, leaves.density.back()};
}

class Selection {
  public:
    Selection(const storage::OctreeNodes& nodes, const storage::Leaves& leaves,
              std::span<const storage::PackedPosition> positions)
        : nodes_(nodes), leaves_(leaves), positions_(positions), scale_(scaleOf(leaves)) {}

    BuiltPreview run() {
        const std::size_t total = std::min<std::size_t>(positions_.size() / 4, Preview::mostPoints);
        if (total == 0) return {};
        collect(fractionFor(total));
        tbb::parallel_sort(candidates_.begin(), candidates_.end());
        candidates_.resize(total);
        return decode();
    }

  private:
    struct Candidate {
        double from;  ///< the fraction that draws it
        std::uint32_t leaf;
        std::uint32_t place;  ///< in its leaf
        bool operator<(const Candidate& other) const {
            if (from != other.from) return from < other.from;
            return leaf != other.leaf ? leaf < other.leaf : place < other.place;
        }
    };

    std::uint32_t drawn(std::size_t leaf, double fraction) const {
        const auto node = leaves_.node[leaf];
        return drawnPoints(fraction, leaves_.pointCount[leaf], nodes_.level[node], nodes_.morton[node]);
    }

    /// A fraction that draws at least `total` points, and few more.
    double fractionFor(std::size_t total) const {
        double fraction = static_cast<double>(total) / static_cast<double>(positions_.size());
        // The drawn points are as many as wanted but for chance; a fraction of 1 draws all.
        for (; fraction < 1.0; fraction *= 1.01) {
            const auto sum = tbb::parallel_reduce(
                tbb::blocked_range<std::size_t>(0, leaves_.size(), blockLeaves), std::size_t{0},
                [&](const tbb::blocked_range<std::size_t>& part, std::size_t count) {
                    for (auto leaf = part.begin(); leaf < part.end(); ++leaf) count += drawn(leaf, fraction);
                    return count;
                },
                std::plus<>());
            if (sum >= total) break;
        }
        // A little more, so that no point is lost to the rounding of drawnPoints.
        return std::min(1.0, fraction * (1.0 + 1e-9));
    }

    void collect(double fraction) {
        const std::size_t blocks = (leaves_.size() + blockLeaves - 1) / blockLeaves;
        std::vector<std::size_t> first(blocks + 1);
        const auto forBlock = [&](std::size_t block, auto use) {
            const std::size_t end = std::min(leaves_.size(), (block + 1) * blockLeaves);
            for (std::size_t leaf = block * blockLeaves; leaf < end; ++leaf) use(leaf, drawn(leaf, fraction));
        };
        tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t block) {
            forBlock(block, [&](std::size_t, std::uint32_t count) { first[block + 1] += count; });
        });
        for (std::size_t block = 0; block < blocks; ++block) first[block + 1] += first[block];
        candidates_.resize(first.back());
        tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t block) {
            std::size_t at = first[block];
            forBlock(block, [&](std::size_t leaf, std::uint32_t count) {
                const auto node = leaves_.node[leaf];
                const double offset = leafOffset(nodes_.level[node], nodes_.morton[node]);
                for (std::uint32_t place = 0; place < count; ++place) {
                    candidates_[at++] = {drawnFrom(place, leaves_.pointCount[leaf], offset),
                                         static_cast<std::uint32_t>(leaf), place};
                }
            });
        });
    }

    PreviewPoint point(const Candidate& candidate) const {
        const auto node = leaves_.node[candidate.leaf];
        const unsigned level = nodes_.level[node];
        const auto cell = mortonCell(nodes_.morton[node]);
        const auto& inCell = positions_[leaves_.pointBegin[candidate.leaf] + candidate.place];
        const auto place = [&](std::size_t axis, std::uint16_t within) {
            return static_cast<std::uint16_t>(((std::uint64_t{cell[axis]} << 16) | within) >> level);
        };
        const double density = leaves_.density[candidate.leaf];
        const double t = density > 0.0 ? scale_.ofLeaf(density) : 0.0;
        return {place(0, inCell.x), place(1, inCell.y), place(2, inCell.z),
                static_cast<std::uint16_t>(std::lround(65535.0 * t))};
    }

    BuiltPreview decode() const {
        BuiltPreview preview;
        preview.points.resize(candidates_.size());
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, candidates_.size(), 1 << 14),
                          [&](const auto& part) {
                              for (auto i = part.begin(); i < part.end(); ++i) {
                                  preview.points[i] = point(candidates_[i]);
                              }
                          });
        for (std::size_t i = 0; i < candidates_.size(); i += Preview::blockPoints) {
            preview.threshold.push_back(static_cast<float>(candidates_[i].from));
        }
        return preview;
    }

    const storage::OctreeNodes& nodes_;
    const storage::Leaves& leaves_;
    std::span<const storage::PackedPosition> positions_;
    LogDensity scale_;
    std::vector<Candidate> candidates_;
};

}  // namespace

BuiltPreview buildPreview(const storage::OctreeNodes& nodes, const storage::Leaves& leaves,
                          std::span<const storage::PackedPosition> positions) {
    return Selection(nodes, leaves, positions).run();
}

}  // namespace mote::prep
