// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/moved_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "protocol/base/mote_check.h"
#include "server/render/plan/in_turns.h"
#include "storage/numbers/point_places.h"
#include "storage/particles/selected_step.h"

namespace mote::render {
namespace {

constexpr std::size_t leavesABlock = 1024;
constexpr std::uint8_t finestLevel = 8;  // of a cell; its own where its leaf is coarser

/// Points in cells of their own.
struct MovedCells {
    std::vector<std::uint8_t> level;  // by cell, as all but the positions and codes
    std::vector<std::uint64_t> morton;
    std::vector<std::uint32_t> count;
    std::vector<std::uint16_t> weights;
    std::vector<std::uint8_t> levels;
    std::vector<storage::PackedPosition> positions;
    std::vector<ValueCode> codes;
};

std::uint64_t mortonOf(const glm::uvec3& place) {
    std::uint64_t code = 0;
    for (unsigned bit = 0; bit < finestLevel; ++bit) {
        for (int axis = 0; axis < 3; ++axis)
            code |= std::uint64_t{place[axis] >> bit & 1U} << (3 * bit + static_cast<unsigned>(axis));
    }
    return code;
}

class MovedStep final : public storage::ParticleStep {
  public:
    explicit MovedStep(MovedCells cells, LogDensity scale) : cells_(std::move(cells)), scale_(scale) {
        std::uint64_t points = 0;
        for (std::uint32_t cell = 0; cell < cells_.count.size(); ++cell) {
            node_.push_back(cell);
            begin_.push_back(points);
            points += cells_.count[cell];
        }
        none_.resize(node_.size());
    }

    storage::OctreeNodes nodes() const override {
        return {cells_.level, cells_.morton, {}, {}, {}, none_, none_};
    }
    storage::Leaves leaves() const override { return {node_, begin_, cells_.count, none_}; }
    std::uint64_t pointCount() const override { return cells_.positions.size(); }
    std::span<const storage::PackedPosition> positions(std::uint64_t begin,
                                                       std::uint64_t count) const override {
        MOTE_CHECK(begin <= cells_.positions.size() && count <= cells_.positions.size() - begin);
        return std::span(cells_.positions).subspan(begin, count);
    }
    std::span<const std::uint64_t> rows(std::uint64_t, std::uint64_t count) const override {
        MOTE_CHECK(count == 0);
        return {};
    }
    std::span<const float> volume() const override { return {}; }
    std::uint32_t volumeSize() const override { return 1; }
    LogDensity logDensity() const override { return scale_; }

  private:
    const MovedCells cells_;
    const LogDensity scale_;
    std::vector<std::uint32_t> node_;  // by cell: itself
    std::vector<std::uint64_t> begin_;
    std::vector<float> none_;
};

/// The points of a step that are drawn.
class DrawnLeaves {
  public:
    DrawnLeaves(const storage::ParticleStep& step, const PointSelection* selection, const PointValues* values)
        : step_(step), walk_(step), selection_(selection), values_(values) {
        MOTE_CHECK(selection == nullptr || selection->drawn.size() <= step.leaves().size());
    }

    std::size_t leaves() const {
        return selection_ == nullptr ? walk_.leaves().size() : selection_->drawn.size();
    }

  protected:
    std::uint32_t drawn(std::size_t leaf) const {
        return selection_ == nullptr ? walk_.leaves().pointCount[leaf] : selection_->drawn[leaf];
    }
    ValueCode codeOf(std::size_t leaf, std::uint64_t point) const {
        return values_ == nullptr ? noValue : values_->codes[values_->byLeaf ? leaf : point];
    }
    void put(const storage::PackedPosition& position, ValueCode code, MovedCells& out) const {
        out.positions.push_back(position);
        if (values_ != nullptr) out.codes.push_back(code);
    }
    void endCell(std::size_t leaf, std::uint8_t level, std::uint64_t morton, std::size_t count,
                 MovedCells& out) const {
        out.level.push_back(level);
        out.morton.push_back(morton);
        out.count.push_back(static_cast<std::uint32_t>(count));
        if (selection_ != nullptr && !selection_->levels.empty())
            out.levels.push_back(selection_->levels[leaf]);
        if (selection_ != nullptr && !selection_->weights.empty())
            out.weights.push_back(selection_->weights[leaf]);
    }

    const storage::ParticleStep& step_;
    const storage::LeafWalk walk_;

  private:
    const PointSelection* const selection_;
    const PointValues* const values_;
};

/// Moves the points of some leaves.
class Mover : public DrawnLeaves {
  public:
    Mover(const storage::ParticleStep& step, const PointSelection* selection, const PointWays& ways,
          double share, const PointValues* values)
        : DrawnLeaves(step, selection, values), places_(ways, share) {
        if (const auto* const chosen = dynamic_cast<const storage::SelectedStep*>(&step))
            sources_ = chosen->sources();
    }

    void take(std::size_t leaf, MovedCells& out) {
        const auto begin = walk_.leaves().pointBegin[leaf];
        const auto drawn = this->drawn(leaf);
        const auto level = std::min(walk_.nodes().level[walk_.leaves().node[leaf]], finestLevel);
        const auto cell = walk_.cell(leaf);
        found_.clear();
        const auto positions = step_.positions(begin, drawn);
        for (std::uint32_t i = 0; i < drawn; ++i) {
            const auto point = begin + i;
            const auto place =
                places_(sources_.empty() ? point : sources_[point], 0.5 * (cell.at(positions[i]) + 1.0));
            found_.push_back(inCell(place, level, leaf, point));
        }
        std::ranges::stable_sort(found_, {}, &Found::cell);
        for (std::size_t first = 0, end = 0; first < found_.size(); first = end) {
            for (; end < found_.size() && found_[end].cell == found_[first].cell; ++end)
                put(found_[end].position, found_[end].code, out);
            const auto at = found_[first].cell;
            endCell(leaf, level, mortonOf({at & 0xffffU, at >> 16 & 0xffffU, at >> 32}), end - first, out);
        }
    }

  private:
    struct Found {
        std::uint64_t cell;  ///< 16 bits for x, y and z from bit 0
        storage::PackedPosition position;
        ValueCode code;
    };

    Found inCell(const glm::dvec3& place, std::uint8_t level, std::size_t leaf, std::uint64_t point) const {
        Found found{0, {}, noValue};
        std::array<std::uint16_t, 3> within{};
        for (int axis = 0; axis < 3; ++axis) {
            // A curve may swing out of the plot: what does stays at its side.
            const auto at = static_cast<std::uint64_t>(std::clamp(place[axis], 0.0, 1.0 - 0x1p-30) *
                                                       std::ldexp(1.0, level + 16));
            found.cell |= (at >> 16) << (16 * axis);
            within[static_cast<std::size_t>(axis)] = static_cast<std::uint16_t>(at & 0xffffU);
        }
        found.position = {within[0], within[1], within[2]};
        found.code = codeOf(leaf, point);
        return found;
    }

    const PlacesOnTheWay places_;
    std::span<const std::uint32_t> sources_;  // empty: the ways are the step's own
    std::vector<Found> found_;                // of a leaf
};

/// Keeps of some leaves' points those that clips leave.
class Cutter : public DrawnLeaves {
  public:
    Cutter(const storage::ParticleStep& step, const PointSelection* selection, const HalfSpaces& clips,
           const PointValues* values)
        : DrawnLeaves(step, selection, values), clips_(clips) {}

    void take(std::size_t leaf, MovedCells& out) const {
        const auto drawn = this->drawn(leaf);
        const auto cell = walk_.cell(leaf);
        if (drawn == 0 || allCut(clips_, {cell.low, cell.low + cell.edge})) return;
        const auto begin = walk_.leaves().pointBegin[leaf];
        const auto before = out.positions.size();
        std::uint64_t point = begin;
        for (const auto& position : step_.positions(begin, drawn)) {
            if (inAll(clips_, cell.at(position))) put(position, codeOf(leaf, point), out);
            ++point;
        }
        const auto node = walk_.leaves().node[leaf];
        const auto count = out.positions.size() - before;
        if (count > 0) endCell(leaf, walk_.nodes().level[node], walk_.nodes().morton[node], count, out);
    }

  private:
    const HalfSpaces& clips_;
};

template <class T>
void appendTo(std::vector<T>& all, std::vector<T>& part) {
    all.insert(all.end(), part.begin(), part.end());
    part = {};
}

MovedCells joinedCells(std::vector<MovedCells> parts) {
    MovedCells all;
    std::size_t points = 0;
    for (const auto& part : parts) points += part.positions.size();
    all.positions.reserve(points);
    for (auto& part : parts) {
        appendTo(all.level, part.level);
        appendTo(all.morton, part.morton);
        appendTo(all.count, part.count);
        appendTo(all.weights, part.weights);
        appendTo(all.levels, part.levels);
        appendTo(all.positions, part.positions);
        appendTo(all.codes, part.codes);
        giveWay();
    }
    return all;
}

/// `taker`: takes leaf after leaf.
template <class Taker>
MovedPoints taken(const Taker& taker, const storage::ParticleStep& step, const PointSelection* selection,
                  const PointValues* values) {
    std::vector<MovedCells> parts((taker.leaves() + leavesABlock - 1) / leavesABlock);
    forInTurns(std::size_t{0}, parts.size(), [&](std::size_t part) {
        Taker own = taker;
        const auto end = std::min(taker.leaves(), (part + 1) * leavesABlock);
        for (auto leaf = part * leavesABlock; leaf < end; ++leaf) own.take(leaf, parts[part]);
    });
    auto cells = joinedCells(std::move(parts));
    auto moved = std::make_shared<PointSelection>();
    moved->drawn = cells.count;
    moved->points = cells.positions.size();
    moved->weights = std::move(cells.weights);
    moved->levels = std::move(cells.levels);
    if (selection != nullptr) moved->weight = selection->weight;
    MovedPoints out;
    if (values != nullptr) {
        auto codes = std::make_shared<PointValues>();
        codes->codes = std::move(cells.codes);
        codes->complete = values->complete;
        out.values = std::move(codes);
    }
    out.selection = std::move(moved);
    out.step = std::make_shared<const MovedStep>(std::move(cells), step.logDensity());
    return out;
}

}  // namespace

MovedPoints movePoints(const storage::ParticleStep& step, const PointSelection* selection,
                       const PointWays& ways, double share, const PointValues* values) {
    return taken(Mover(step, selection, ways, share, values), step, selection, values);
}

MovedPoints cutPoints(const storage::ParticleStep& step, const PointSelection* selection,
                      const HalfSpaces& clips, const PointValues* values) {
    return taken(Cutter(step, selection, clips, values), step, selection, values);
}

}  // namespace mote::render
