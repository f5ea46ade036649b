// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/memory_step.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <tuple>

#include "protocol/base/mote_check.h"
#include "protocol/scene/drawn_points.h"

namespace mote::test {
namespace {

using storage::Preview;
using storage::PreviewPoint;

/// The fraction that draws a point, its leaf, its place in the leaf.
using Drawn = std::tuple<double, std::size_t, std::uint32_t>;

/// The leaf's cell and the 16 bits within it as one number, of which the 16 highest are the place in the box.
std::uint16_t inBox(std::uint64_t morton, unsigned axis, unsigned level, std::uint16_t inCell) {
    std::uint64_t cell = 0;
    for (unsigned bit = 0; bit < level; ++bit) cell |= (morton >> (3 * bit + axis) & 1U) << bit;
    return static_cast<std::uint16_t>((cell * 65536 + inCell) >> level);
}

std::vector<Drawn> inOrder(const storage::ParticleStep& step) {
    const auto nodes = step.nodes();
    const auto leaves = step.leaves();
    std::vector<Drawn> order;
    for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf) {
        const auto node = leaves.node[leaf];
        const double offset = leafOffset(nodes.level[node], nodes.morton[node]);
        for (std::uint32_t i = 0; i < leaves.pointCount[leaf]; ++i) {
            order.emplace_back((i + 1.0 - offset) / leaves.pointCount[leaf], leaf, i);
        }
    }
    std::sort(order.begin(), order.end());
    order.resize(std::min<std::size_t>(order.size() / 4, Preview::mostPoints));
    return order;
}

LogDensity scaleOf(const storage::ParticleStep& step) {
    LogDensity scale;
    for (const float density : step.leaves().density) {
        if (!(density > 0.0F)) continue;
        if (scale.min == 1.0 && scale.max == 1.0) scale = {density, density};
        scale = {std::min<double>(scale.min, density), std::max<double>(scale.max, density)};
    }
    return scale;
}

}  // namespace

Preview BrutePreview::first(std::uint64_t most) const {
    if (points.empty()) return {};
    const auto shown = std::span(points).first(std::min<std::uint64_t>(most, points.size()));
    return {shown, points.size(), threshold, scale};
}

BrutePreview brutePreview(const storage::ParticleStep& step) {
    BrutePreview preview;
    preview.scale = scaleOf(step);
    const auto nodes = step.nodes();
    const auto leaves = step.leaves();
    for (const auto& [from, leaf, place] : inOrder(step)) {
        if (preview.points.size() % Preview::blockPoints == 0) {
            preview.threshold.push_back(static_cast<float>(from));
        }
        const auto node = leaves.node[leaf];
        const auto inCell = step.positions(leaves.pointBegin[leaf] + place, 1).front();
        const auto at = [&](unsigned axis, std::uint16_t within) {
            return inBox(nodes.morton[node], axis, nodes.level[node], within);
        };
        const double density = leaves.density[leaf];
        const double t = density > 0.0 ? preview.scale.ofLeaf(density) : 0.0;
        preview.points.push_back({at(0, inCell.x), at(1, inCell.y), at(2, inCell.z),
                                  static_cast<std::uint16_t>(std::lround(65535.0 * t))});
    }
    return preview;
}

namespace {

/// A cell while the octree grows: all its points, nothing shared.
struct Cell {
    std::uint8_t level = 0;
    std::array<std::uint32_t, 3> place{};  // column, row and slice at its level
    std::vector<std::uint64_t> points;     // rows
};

std::uint64_t mortonOf(const std::array<std::uint32_t, 3>& place) {
    std::uint64_t code = 0;
    for (unsigned bit = 0; bit < 21; ++bit) {
        for (unsigned axis = 0; axis < 3; ++axis) {
            code |= std::uint64_t{(place[axis] >> bit) & 1U} << (3 * bit + axis);
        }
    }
    return code;
}

std::uint32_t placeAt(double coordinate, std::uint32_t cells) {
    return std::min(static_cast<std::uint32_t>(coordinate * cells), cells - 1);
}

std::uint16_t packed(double coordinate, std::uint32_t place, std::uint8_t level) {
    const double inCell = std::ldexp(coordinate, level) - place;
    return static_cast<std::uint16_t>(std::clamp(inCell * 65536.0, 0.0, 65535.0));
}

/// The cells one level below a cell, in Morton order, with its points.
std::array<Cell, 8> childrenOf(const Cell& cell, const std::vector<WeightedPoint>& points) {
    std::array<Cell, 8> children;
    const auto level = static_cast<std::uint8_t>(cell.level + 1);
    for (std::uint32_t number = 0; number < 8; ++number) {
        children[number].level = level;
        for (unsigned axis = 0; axis < 3; ++axis)
            children[number].place[axis] = 2 * cell.place[axis] + (number >> axis & 1U);
    }
    for (const auto row : cell.points) {
        std::array<std::uint32_t, 3> place{};
        for (int axis = 0; axis < 3; ++axis) place[axis] = placeAt(points[row].position[axis], 1U << level);
        children[mortonOf(place) & 7U].points.push_back(row);
    }
    return children;
}

/// The mean of a volume's cells in each cell of every level, the deepest last.
class VolumeMeans {
  public:
    VolumeMeans(const std::vector<float>& volume, std::uint8_t level) : levels_(level + 1U) {
        levels_.back().assign(volume.begin(), volume.end());
        for (unsigned coarse = level; coarse-- > 0;) {
            const std::uint32_t side = 2U << coarse;
            levels_[coarse].assign(std::size_t{1} << (3 * coarse), 0.0);
            for (std::size_t i = 0; i < levels_[coarse + 1].size(); ++i) {
                const std::size_t x = i % side, y = i / side % side, z = i / side / side;
                levels_[coarse][((z / 2) * (side / 2) + y / 2) * (side / 2) + x / 2] +=
                    levels_[coarse + 1][i] / 8.0;
            }
        }
    }
    double of(const Cell& cell) const {
        const std::size_t side = std::size_t{1} << cell.level;
        return levels_[cell.level][(cell.place[2] * side + cell.place[1]) * side + cell.place[0]];
    }

  private:
    std::vector<std::vector<double>> levels_;
};

}  // namespace

class MemoryStepBuilder {
  public:
    MemoryStepBuilder(const std::vector<WeightedPoint>& points, const MemoryStepOptions& options)
        : points_(points), options_(options) {
        for (const auto& point : points) {
            for (int axis = 0; axis < 3; ++axis) {
                MOTE_CHECK(point.position[axis] >= 0.0 && point.position[axis] <= 1.0);
            }
            MOTE_CHECK(point.weight > 0.0);
        }
        MOTE_CHECK(options.maxLevel <= 20 && options.volumeLevel <= 8);
    }

    std::shared_ptr<const MemoryStep> build() {
        if (std::any_of(options_.volume.begin(), options_.volume.end(), [](float x) { return x > 0.0F; }))
            means_.emplace(options_.volume, options_.volumeLevel);
        growTree();
        if (!points_.empty() || means_) orderLeaves();
        spreadLeastDensities();
        writePoints();
        countVolume();
        setScale();
        step_->preview_ = brutePreview(*step_);
        return step_;
    }

  private:
    /// Breadth first: a node's children are numbered when the node is visited.
    void growTree() {
        Cell root;
        root.points.resize(points_.size());
        std::iota(root.points.begin(), root.points.end(), std::uint64_t{0});
        cells_.push_back(std::move(root));
        for (std::size_t i = 0; i < cells_.size(); ++i) {
            addNode(cells_[i]);
            const bool full = means_ || cells_[i].points.size() > options_.leafCapacity;
            if (!full || cells_[i].level >= (means_ ? options_.volumeLevel : options_.maxLevel)) continue;
            step_->firstChild_[i] = static_cast<std::uint32_t>(cells_.size());
            for (auto& child : childrenOf(cells_[i], points_)) {
                if (child.points.empty() && !(means_ && means_->of(child) > 0.0)) continue;
                ++step_->childCount_[i];
                cells_.push_back(std::move(child));
            }
        }
    }

    void addNode(const Cell& cell) {
        double weight = 0.0;
        for (const auto row : cell.points) weight += points_[row].weight;
        step_->level_.push_back(cell.level);
        step_->morton_.push_back(mortonOf(cell.place));
        step_->firstChild_.push_back(0);
        step_->childCount_.push_back(0);
        step_->count_.push_back(cell.points.size());
        step_->density_.push_back(
            static_cast<float>(means_ ? means_->of(cell) : std::ldexp(weight, 3 * cell.level)));
    }

    void orderLeaves() {
        for (std::uint32_t i = 0; i < cells_.size(); ++i) {
            if (step_->childCount_[i] == 0) step_->leafNode_.push_back(i);
        }
        std::stable_sort(step_->leafNode_.begin(), step_->leafNode_.end(),
                         [&](auto a, auto b) { return step_->density_[a] < step_->density_[b]; });
        std::uint64_t begin = 0;
        for (std::uint32_t leaf = 0; leaf < step_->leafNode_.size(); ++leaf) {
            const auto node = step_->leafNode_[leaf];
            step_->firstChild_[node] = leaf;
            step_->leafBegin_.push_back(begin);
            step_->leafCount_.push_back(static_cast<std::uint32_t>(step_->count_[node]));
            step_->leafDensity_.push_back(step_->density_[node]);
            begin += step_->count_[node];
        }
    }

    void spreadLeastDensities() {
        step_->minDensity_ = step_->density_;
        for (std::size_t i = cells_.size(); i-- > 0;) {
            if (step_->childCount_[i] == 0) continue;
            float least = std::numeric_limits<float>::infinity();
            for (std::uint32_t k = 0; k < step_->childCount_[i]; ++k) {
                least = std::min(least, step_->minDensity_[step_->firstChild_[i] + k]);
            }
            step_->minDensity_[i] = least;
        }
    }

    void writePoints() {
        std::mt19937_64 random(options_.seed);
        for (const auto node : step_->leafNode_) {
            auto& cell = cells_[node];
            for (std::size_t i = cell.points.size(); i > 1; --i) {
                std::swap(cell.points[i - 1], cell.points[random() % i]);
            }
            for (const auto row : cell.points) {
                const auto& p = points_[row].position;
                step_->positions_.push_back({packed(p.x, cell.place[0], cell.level),
                                             packed(p.y, cell.place[1], cell.level),
                                             packed(p.z, cell.place[2], cell.level)});
                step_->rows_.push_back(row);
            }
        }
    }

    void countVolume() {
        const std::uint32_t size = 1U << options_.volumeLevel;
        step_->volumeSize_ = size;
        const std::size_t cells = std::size_t{size} * size * size;
        if (!options_.volume.empty()) {
            MOTE_CHECK(options_.volume.size() == cells);
            step_->volume_ = options_.volume;
            return;
        }
        std::vector<double> weights(cells, 0.0);
        for (const auto& [p, weight] : points_) {
            const std::size_t row = std::size_t{placeAt(p.z, size)} * size + placeAt(p.y, size);
            weights[row * size + placeAt(p.x, size)] += weight;
        }
        step_->volume_.resize(cells);
        std::transform(weights.begin(), weights.end(), step_->volume_.begin(), [&](double weight) {
            return static_cast<float>(weight * static_cast<double>(cells));
        });
    }

    void setScale() {
        if (options_.logDensity) {
            step_->logDensity_ = *options_.logDensity;
        } else if (!step_->leafDensity_.empty()) {
            step_->logDensity_ = {step_->leafDensity_.front(), step_->leafDensity_.back()};
        }
    }

    const std::vector<WeightedPoint>& points_;
    const MemoryStepOptions& options_;
    std::vector<Cell> cells_;
    std::optional<VolumeMeans> means_;  // of a volume that is given
    std::shared_ptr<MemoryStep> step_ = std::make_shared<MemoryStep>();
};

std::shared_ptr<const MemoryStep> MemoryStep::make(const std::vector<WeightedPoint>& points,
                                                   const MemoryStepOptions& options) {
    return MemoryStepBuilder(points, options).build();
}

storage::OctreeNodes MemoryStep::nodes() const {
    return {level_, morton_, firstChild_, childCount_, count_, density_, minDensity_};
}

storage::Leaves MemoryStep::leaves() const {
    return {leafNode_, leafBegin_, leafCount_, leafDensity_};
}

std::span<const storage::PackedPosition> MemoryStep::positions(std::uint64_t begin,
                                                               std::uint64_t count) const {
    MOTE_CHECK(begin <= positions_.size() && count <= positions_.size() - begin);
    return std::span(positions_).subspan(begin, count);
}

std::span<const std::uint64_t> MemoryStep::rows(std::uint64_t begin, std::uint64_t count) const {
    MOTE_CHECK(begin <= rows_.size() && count <= rows_.size() - begin);
    return std::span(rows_).subspan(begin, count);
}

}  // namespace mote::test
