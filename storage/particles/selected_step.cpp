// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/particles/selected_step.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "protocol/base/mote_check.h"
#include "storage/storage_error.h"

namespace mote::storage {
namespace {

constexpr std::size_t blockLeaves = 4096;
constexpr std::uint32_t nowhere = std::numeric_limits<std::uint32_t>::max();

/// Calls visit(leaf) for all of them on all threads; false if `cancelled` said to stop.
template <class Visit>
bool forLeaves(std::size_t leaves, const std::function<bool()>& cancelled, const Visit& visit) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, leaves, blockLeaves), [&](const auto& block) {
        if (cancelled && cancelled()) return;
        for (std::size_t leaf = block.begin(); leaf < block.end(); ++leaf) visit(leaf);
    });
    return !(cancelled && cancelled());
}

/// How many of the points [begin, end) are chosen.
std::uint32_t chosenOf(const PointMask& mask, std::uint64_t begin, std::uint64_t end) {
    constexpr auto bits = PointMask::wordBits;
    std::uint32_t count = 0;
    while (begin < end) {
        const auto first = begin % bits, here = std::min(bits - first, end - begin);
        const auto kept = ~std::uint64_t{0} >> (bits - here);
        count += static_cast<std::uint32_t>(std::popcount((mask.words()[begin / bits] >> first) & kept));
        begin += here;
    }
    return count;
}

/// Every third bit of a Morton code, from bit `axis`: a cell's place along that axis.
std::uint32_t placeAlong(std::uint64_t morton, unsigned axis) {
    std::uint32_t place = 0;
    for (unsigned bit = 0; 3 * bit + axis < 64; ++bit)
        place |= static_cast<std::uint32_t>(morton >> (3 * bit + axis) & 1U) << bit;
    return place;
}

}  // namespace

/// Makes one step. The nodes of the run's octree are told by their numbers there.
class StepSelector {
  public:
    StepSelector(const ParticleStep& step, const PointMask& mask, std::uint32_t leafCapacity,
                 const std::function<bool()>& cancelled)
        : step_(step),
          mask_(mask),
          leafCapacity_(leafCapacity),
          cancelled_(cancelled),
          nodes_(step.nodes()),
          leaves_(step.leaves()) {}

    Result<std::shared_ptr<SelectedStep>> make() {
        if (step_.pointCount() > std::numeric_limits<std::uint32_t>::max()) {
            return Error{ErrorCode::resourceExhausted, "select",
                         "a step of more than 2^32 points is drawn as a whole only"};
        }
        out_->logDensity_ = step_.logDensity();
        if (!countLeaves()) return wasCancelled();
        countNodes();
        spreadDensities();
        orderLeaves();
        keepNodes();
        if (!copyPoints()) return wasCancelled();
        countVolume();
        if (cancelled_ && cancelled_()) return wasCancelled();
        return out_;
    }

  private:
    bool isLeaf(std::size_t node) const { return nodes_.childCount[node] == 0; }

    bool countLeaves() {
        chosen_.resize(leaves_.size());
        return forLeaves(leaves_.size(), cancelled_, [&](std::size_t leaf) {
            const auto begin = leaves_.pointBegin[leaf];
            chosen_[leaf] = chosenOf(mask_, begin, begin + leaves_.pointCount[leaf]);
        });
    }

    /// Counts and weights, from the leaves up: children stand behind their parents.
    void countNodes() {
        count_.assign(nodes_.size(), 0);
        weight_.assign(nodes_.size(), 0.0);
        for (std::size_t leaf = 0; leaf < leaves_.size(); ++leaf) {
            const auto node = leaves_.node[leaf];
            if (chosen_[leaf] == 0) continue;  // of a leaf without points no share is a number
            count_[node] = chosen_[leaf];
            const double share = static_cast<double>(chosen_[leaf]) / leaves_.pointCount[leaf];
            weight_[node] =
                share * std::ldexp(static_cast<double>(leaves_.density[leaf]), -3 * nodes_.level[node]);
        }
        for (std::size_t node = nodes_.size(); node-- > 0;) {
            for (std::uint32_t child = 0; child < nodes_.childCount[node]; ++child) {
                count_[node] += count_[nodes_.firstChild[node] + child];
                weight_[node] += weight_[nodes_.firstChild[node] + child];
            }
        }
    }

    /// The density of each leaf is that of the cell which would be a leaf if the chosen were all there are:
    /// the largest around it that holds no more than a leaf may.
    void spreadDensities() {
        density_.assign(nodes_.size(), 0.0F);
        std::vector<bool> settled(nodes_.size(), false);  // the density is of a cell around it
        for (std::size_t node = 0; node < nodes_.size(); ++node) {
            if (!settled[node]) {
                const double own = std::ldexp(weight_[node], 3 * nodes_.level[node]);
                constexpr double most = std::numeric_limits<float>::max();
                density_[node] = static_cast<float>(std::min(own, most));
            }
            const bool settles = settled[node] || count_[node] <= leafCapacity_;
            for (std::uint32_t child = 0; settles && child < nodes_.childCount[node]; ++child) {
                settled[nodes_.firstChild[node] + child] = true;
                density_[nodes_.firstChild[node] + child] = density_[node];
            }
        }
    }

    void orderLeaves() {
        for (std::uint32_t leaf = 0; leaf < leaves_.size(); ++leaf) {
            if (chosen_[leaf] > 0) order_.push_back(leaf);
        }
        std::stable_sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
            return density_[leaves_.node[a]] < density_[leaves_.node[b]];
        });
        std::uint64_t begin = 0;
        for (const auto leaf : order_) {
            out_->leafBegin_.push_back(begin);
            out_->leafCount_.push_back(chosen_[leaf]);
            out_->leafDensity_.push_back(density_[leaves_.node[leaf]]);
            begin += chosen_[leaf];
        }
    }

    /// Those that hold any, in their order, and the root.
    void keepNodes() {
        std::vector<std::uint32_t> place(nodes_.size(), nowhere);
        std::uint32_t kept = 0;
        for (std::size_t node = 0; node < nodes_.size(); ++node) {
            if (count_[node] > 0 || node == 0) place[node] = kept++;
        }
        std::vector<std::uint32_t> leafPlace(leaves_.size(), nowhere);
        for (std::uint32_t i = 0; i < order_.size(); ++i) leafPlace[order_[i]] = i;
        for (std::size_t node = 0; node < nodes_.size(); ++node) {
            if (place[node] != nowhere) keepNode(node, place, leafPlace);
        }
        out_->leafNode_.reserve(order_.size());
        for (const auto leaf : order_) out_->leafNode_.push_back(place[leaves_.node[leaf]]);
        out_->minDensity_ = out_->density_;
        for (std::size_t i = out_->density_.size(); i-- > 0;) {
            if (out_->childCount_[i] == 0) continue;
            const auto first = out_->minDensity_.begin() + static_cast<std::ptrdiff_t>(out_->firstChild_[i]);
            out_->minDensity_[i] = *std::min_element(first, first + out_->childCount_[i]);
        }
    }

    void keepNode(std::size_t node, const std::vector<std::uint32_t>& place,
                  const std::vector<std::uint32_t>& leafPlace) {
        std::uint8_t children = 0;
        std::uint32_t first = 0;
        for (std::uint32_t child = nodes_.childCount[node]; child-- > 0;) {
            const auto at = place[nodes_.firstChild[node] + child];
            if (at == nowhere) continue;
            first = at;
            ++children;
        }
        if (isLeaf(node) && count_[node] > 0) first = leafPlace[nodes_.firstChild[node]];
        out_->level_.push_back(nodes_.level[node]);
        out_->morton_.push_back(nodes_.morton[node]);
        out_->firstChild_.push_back(first);
        out_->childCount_.push_back(children);
        out_->count_.push_back(count_[node]);
        out_->density_.push_back(density_[node]);
    }

    /// In their order within each leaf: what is chosen of a shuffle is one.
    bool copyPoints() {
        const auto points = out_->leafBegin_.empty() ? 0 : out_->leafBegin_.back() + out_->leafCount_.back();
        out_->positions_.resize(points);
        out_->sources_.resize(points);
        return forLeaves(order_.size(), cancelled_, [&](std::size_t i) {
            const auto begin = leaves_.pointBegin[order_[i]];
            const auto count = leaves_.pointCount[order_[i]];
            const auto from = step_.positions(begin, count);
            auto to = out_->leafBegin_[i];
            for (std::uint32_t point = 0; point < count; ++point) {
                if (!mask_.chosen(begin + point)) continue;
                out_->positions_[to] = from[point];
                out_->sources_[to++] = static_cast<std::uint32_t>(begin + point);
            }
        });
    }

    /// Each point weighs the mean of its leaf's. One thread, so that sums have one order.
    void countVolume() {
        const std::uint32_t size = out_->volumeSize_ = step_.volumeSize();
        const auto level = static_cast<unsigned>(std::countr_zero(size));
        std::vector<double> weights(std::size_t{size} * size * size, 0.0);
        for (std::size_t i = 0; i < order_.size(); ++i) {
            const auto leaf = order_[i];
            const auto node = leaves_.node[leaf];
            std::array<std::uint32_t, 3> place{};
            for (unsigned axis = 0; axis < 3; ++axis) place[axis] = placeAlong(nodes_.morton[node], axis);
            if (nodes_.level[node] >= level) {
                for (auto& along : place) along >>= nodes_.level[node] - level;
                weights[cellOf(place, size)] += weight_[node];
            } else {
                addPoints(i, place, level - nodes_.level[node], weight_[node] / chosen_[leaf], weights);
            }
        }
        const auto cells = static_cast<double>(weights.size());
        out_->volume_.resize(weights.size());
        std::transform(weights.begin(), weights.end(), out_->volume_.begin(),
                       [&](double weight) { return static_cast<float>(weight * cells); });
    }

    static std::size_t cellOf(const std::array<std::uint32_t, 3>& place, std::uint32_t size) {
        return (std::size_t{place[2]} * size + place[1]) * size + place[0];
    }

    /// Of a leaf that is 2^below cells of the volume wide.
    void addPoints(std::size_t leaf, const std::array<std::uint32_t, 3>& place, unsigned below, double each,
                   std::vector<double>& weights) const {
        const auto begin = out_->leafBegin_[leaf];
        const auto along = [&](unsigned axis, std::uint16_t p) {
            return (place[axis] << below) + (std::uint32_t{p} >> (16 - below));
        };
        for (std::uint64_t point = begin; point < begin + out_->leafCount_[leaf]; ++point) {
            const auto& p = out_->positions_[point];
            weights[cellOf({along(0, p.x), along(1, p.y), along(2, p.z)}, out_->volumeSize_)] += each;
        }
    }

    const ParticleStep& step_;
    const PointMask& mask_;
    const std::uint32_t leafCapacity_;
    const std::function<bool()>& cancelled_;
    const OctreeNodes nodes_;
    const Leaves leaves_;
    std::vector<std::uint32_t> chosen_;  // by leaf
    std::vector<std::uint64_t> count_;   // by node; of the chosen, as all that follows
    std::vector<double> weight_;         // by node
    std::vector<float> density_;         // by node; a leaf's is that of the cell that would be one
    std::vector<std::uint32_t> order_;   // leaves that hold any, ascending in density
    std::shared_ptr<SelectedStep> out_ = std::make_shared<SelectedStep>();
};

Result<std::shared_ptr<SelectedStep>> SelectedStep::make(const ParticleStep& step, const PointMask& mask,
                                                         std::uint32_t leafCapacity,
                                                         const std::function<bool()>& cancelled) {
    MOTE_CHECK(mask.size() == step.pointCount());
    return StepSelector(step, mask, leafCapacity, cancelled).make();
}

std::span<const PackedPosition> SelectedStep::positions(std::uint64_t begin, std::uint64_t count) const {
    MOTE_CHECK(begin <= positions_.size() && count <= positions_.size() - begin);
    return std::span(positions_).subspan(begin, count);
}

std::span<const std::uint64_t> SelectedStep::rows(std::uint64_t, std::uint64_t count) const {
    MOTE_CHECK(count == 0);
    return {};
}

std::uint64_t SelectedStep::bytes() const {
    const auto of = [](const auto& vector) {
        return vector.capacity() * sizeof(typename std::remove_cvref_t<decltype(vector)>::value_type);
    };
    return of(level_) + of(childCount_) + of(morton_) + of(count_) + of(firstChild_) + of(density_) +
           of(minDensity_) + of(leafNode_) + of(leafCount_) + of(leafBegin_) + of(leafDensity_) +
           of(positions_) + of(sources_) + of(volume_);
}

}  // namespace mote::storage
