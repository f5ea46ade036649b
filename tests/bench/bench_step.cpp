// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/bench_step.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>

namespace mote::bench {
namespace {

std::uint64_t mortonOf(const std::array<std::uint32_t, 3>& place, std::uint8_t level) {
    std::uint64_t code = 0;
    for (unsigned bit = 0; bit < level; ++bit) {
        for (unsigned axis = 0; axis < 3; ++axis)
            code |= std::uint64_t{(place[axis] >> bit) & 1U} << (3 * bit + axis);
    }
    return code;
}

float cellDensity(std::uint64_t count, std::uint8_t level) {
    return static_cast<float>(std::ldexp(static_cast<double>(count), 3 * level));
}

constexpr std::uint32_t volumeSide = 64;

}  // namespace

BenchStep::BenchStep(std::uint64_t pointCount, std::uint8_t leafLevel, std::uint64_t seed)
    : volume_(std::size_t{volumeSide} * volumeSide * volumeSide, 0.0F) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    std::vector<Point> points(pointCount);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double sigma = i % 10 == 0 ? 0.16 : 0.07;
        std::array<std::uint32_t, 3> place{};
        std::array<std::uint16_t, 3> inside{};
        std::size_t cell = 0;
        for (unsigned axis = 0; axis < 3; ++axis) {
            const double x =
                std::clamp(0.5 + sigma * normal(random) * (axis == 2 ? 1.4 : 1.0), 0.0, 0.999999);
            const double scaled = std::ldexp(x, leafLevel);
            place[axis] = static_cast<std::uint32_t>(scaled);
            inside[axis] = static_cast<std::uint16_t>((scaled - place[axis]) * 65536.0);
            cell += static_cast<std::size_t>(x * volumeSide) << (6 * axis);
        }
        volume_[cell] += volumeSide * volumeSide * volumeSide;
        points[i] = {mortonOf(place, leafLevel), {inside[0], inside[1], inside[2]}};
    }
    std::sort(points.begin(), points.end(),
              [](const Point& a, const Point& b) { return a.morton < b.morton; });

    std::vector<std::vector<Cell>> levels(leafLevel + 1U);
    for (const auto& point : points) {
        auto& leaves = levels[leafLevel];
        if (leaves.empty() || leaves.back().morton != point.morton)
            leaves.push_back({point.morton, 0, 0.0F, 0, 0});
        ++leaves.back().count;
    }
    for (auto& leaf : levels[leafLevel]) leaf.minDensity = cellDensity(leaf.count, leafLevel);
    for (unsigned level = leafLevel; level > 0; --level) levels[level - 1] = parentsOf(levels[level]);
    std::uint32_t below = 0;
    for (std::uint8_t level = 0; level <= leafLevel; ++level) {
        below += static_cast<std::uint32_t>(levels[level].size());
        addLevel(levels[level], level, below);
    }
    orderLeaves(levels[leafLevel], below - static_cast<std::uint32_t>(levels[leafLevel].size()), points);
}

std::vector<BenchStep::Cell> BenchStep::parentsOf(const std::vector<Cell>& children) {
    std::vector<Cell> parents;
    for (std::uint32_t i = 0; i < children.size(); ++i) {
        const std::uint64_t morton = children[i].morton >> 3;
        if (parents.empty() || parents.back().morton != morton) {
            parents.push_back({morton, 0, children[i].minDensity, i, 0});
        }
        Cell& parent = parents.back();
        parent.count += children[i].count;
        parent.minDensity = std::min(parent.minDensity, children[i].minDensity);
        ++parent.children;
    }
    return parents;
}

void BenchStep::addLevel(const std::vector<Cell>& cells, std::uint8_t level, std::uint32_t firstBelow) {
    for (const auto& cell : cells) {
        level_.push_back(level);
        morton_.push_back(cell.morton);
        childCount_.push_back(cell.children);
        firstChild_.push_back(firstBelow + cell.first);
        count_.push_back(cell.count);
        density_.push_back(cellDensity(cell.count, level));
        minDensity_.push_back(cell.minDensity);
    }
}

void BenchStep::orderLeaves(const std::vector<Cell>& cells, std::uint32_t firstNode,
                            const std::vector<Point>& points) {
    std::vector<std::uint64_t> begins(cells.size());
    std::uint64_t begin = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        begins[i] = begin;
        begin += cells[i].count;
    }
    std::vector<std::uint32_t> order(cells.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(),
                     [&](auto a, auto b) { return cells[a].count < cells[b].count; });
    for (const std::uint32_t cell : order) {
        const std::uint32_t node = firstNode + cell;
        firstChild_[node] = static_cast<std::uint32_t>(leafNode_.size());
        leafNode_.push_back(node);
        leafCount_.push_back(static_cast<std::uint32_t>(cells[cell].count));
        leafBegin_.push_back(positions_.size());
        leafDensity_.push_back(density_[node]);
        for (std::uint64_t i = 0; i < cells[cell].count; ++i)
            positions_.push_back(points[begins[cell] + i].position);
    }
}

storage::OctreeNodes BenchStep::nodes() const {
    return {level_, morton_, firstChild_, childCount_, count_, density_, minDensity_};
}

storage::Leaves BenchStep::leaves() const {
    return {leafNode_, leafBegin_, leafCount_, leafDensity_};
}

}  // namespace mote::bench
