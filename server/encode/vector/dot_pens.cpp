// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/vector/dot_pens.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "server/encode/vector/paint.h"
#include "server/figures/svg_marks.h"

namespace mote::server {
namespace {

using render::Dots;

constexpr std::size_t mostPens = 16;

std::vector<std::size_t> backToFront(const Dots& dots) {
    std::vector<std::size_t> order(dots.size());
    std::iota(order.rbegin(), order.rend(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](auto a, auto b) { return dots[a].depth > dots[b].depth; });
    return order;
}

/// Finds dots that lie over one another, by squares that no dot exceeds.
class Overlaps {
  public:
    explicit Overlaps(const Dots& dots) : dots_(dots) {
        for (const auto& dot : dots) side_ = std::max(side_, 2.0F * dot.radius);
    }
    void add(std::size_t index) {
        squares_[keyOf(columnOf(dots_[index].x), columnOf(dots_[index].y))].push_back(index);
    }
    /// `check(other)` of all that were added and that it touches, until one is true. Whether one was.
    template <class Check>
    bool any(std::size_t index, Check&& check) const {
        const auto& dot = dots_[index];
        for (std::int64_t i = -1; i <= 1; ++i) {
            for (std::int64_t k = -1; k <= 1; ++k) {
                const auto square = squares_.find(keyOf(columnOf(dot.x) + i, columnOf(dot.y) + k));
                if (square == squares_.end()) continue;
                for (const auto other : square->second) {
                    const auto& at = dots_[other];
                    if (std::hypot(at.x - dot.x, at.y - dot.y) < at.radius + dot.radius && check(other))
                        return true;
                }
            }
        }
        return false;
    }

  private:
    std::int64_t columnOf(float at) const {
        return static_cast<std::int64_t>(std::floor(std::clamp(at / side_, -1e9F, 1e9F)));
    }
    static std::uint64_t keyOf(std::int64_t column, std::int64_t row) {
        return (static_cast<std::uint64_t>(column) << 32) ^ (static_cast<std::uint64_t>(row) & 0xffffffffU);
    }

    const Dots& dots_;
    float side_ = 1e-3F;
    std::unordered_map<std::uint64_t, std::vector<std::size_t>> squares_;
};

/// Whether a pen would draw over a dot of an earlier one that lies nearer.
bool cover(const std::vector<DotPen>& pens, const Dots& dots) {
    Overlaps drawn(dots);
    for (const auto& pen : pens) {
        for (const auto index : pen.dots) {
            if (drawn.any(index, [&](auto other) { return dots[other].depth < dots[index].depth; }))
                return true;
        }
        for (const auto index : pen.dots) drawn.add(index);
    }
    return false;
}

}  // namespace

std::vector<DotPen> pensOf(const Dots& dots, bool plotter) {
    auto order = backToFront(dots);
    std::vector<std::size_t> place(dots.size());
    for (std::size_t i = 0; i < order.size(); ++i) place[order[i]] = i;
    std::map<std::string, std::vector<std::size_t>> colors;
    for (const auto index : order) {
        colors["dots " + hexColor(encoded(dots[index].color))].push_back(index);
        if (colors.size() > mostPens) return {{"dots", std::move(order)}};
    }
    std::vector<DotPen> pens;
    for (auto& [name, its] : colors) pens.push_back({name, std::move(its)});
    if (plotter || pens.size() < 2) return pens;
    const auto middle = [&](const DotPen& pen) {
        double sum = 0.0;
        for (const auto index : pen.dots) sum += static_cast<double>(place[index]);
        return sum / static_cast<double>(pen.dots.size());
    };
    std::stable_sort(pens.begin(), pens.end(),
                     [&](const auto& a, const auto& b) { return middle(a) < middle(b); });
    if (cover(pens, dots)) return {{"dots", std::move(order)}};
    return pens;
}

}  // namespace mote::server
