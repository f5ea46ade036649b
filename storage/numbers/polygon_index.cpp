// SPDX-License-Identifier: GPL-3.0-or-later
//
// A grid of cells. For a place in a cell, an edge that lies wholly to the cell's left never counts, one that
// comes near the cell is tried. One that lies wholly to its right counts where just one of its ends lies at
// or below y: the parity of all of these is that of their ends. An end in another row of cells is known to
// lie below or above; where two such edges meet in the cell's own row their common end cancels; where only
// one of the two lies to the right, their joint is among what is tried.
#include "storage/numbers/polygon_index.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mote::storage {
namespace {

constexpr std::uint32_t mostCells = 1024;  // along each side
constexpr double cornerRounding = 32 * std::numeric_limits<double>::epsilon();
constexpr std::uint64_t mostEntries = std::uint64_t{1} << 24;  // 64 MiB

}  // namespace

PolygonIndex::PolygonIndex(std::span<const glm::dvec2> corners) {
    makeEdges(corners);
    if (edges_.empty()) return;
    const double wide = highX_ - lowX_;
    marginX_ = 1e-9 * wide + cornerRounding * std::max(std::abs(lowX_), std::abs(highX_));
    marginY_ = cornerRounding * std::max(std::abs(lowY_), std::abs(highY_));
    const auto wanted = 8.0 * std::sqrt(static_cast<double>(edges_.size()));
    cells_ = std::min(mostCells, static_cast<std::uint32_t>(wanted));
    while (cells_ > 1 && !fits(cells_)) cells_ /= 2;
    scaleX_ = wide > 0.0 ? cells_ / wide : 0.0;
    scaleY_ = cells_ / (highY_ - lowY_);
    fill();
}

/// Level edges never count, so their ends are one joint.
void PolygonIndex::makeEdges(std::span<const glm::dvec2> corners) {
    lowX_ = lowY_ = std::numeric_limits<double>::infinity();
    highX_ = highY_ = -lowX_;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        auto a = corners[i], b = corners[(i + 1) % corners.size()];
        lowX_ = std::min(lowX_, a.x);
        highX_ = std::max(highX_, a.x);
        lowY_ = std::min(lowY_, a.y);
        highY_ = std::max(highY_, a.y);
        if (a.y == b.y) continue;
        const double y = a.y;  // where it joins the edge before it
        if (b.y < a.y) std::swap(a, b);
        edges_.push_back({a.x, a.y, b.x, b.y, std::min(a.x, b.x), std::max(a.x, b.x)});
        joints_.push_back({edges_.size() - 1, 0, y});
    }
    for (std::size_t i = 0; i < joints_.size(); ++i)
        joints_[i].second = (i + joints_.size() - 1) % joints_.size();
}

std::uint32_t PolygonIndex::cell(double value, double low, double scale) const {
    const double place = (value - low) * scale;
    if (!(place > 0.0)) return 0;
    return place < cells_ ? static_cast<std::uint32_t>(place) : cells_ - 1;
}

/// Whether so many cells along each side give no more entries than are allowed.
bool PolygonIndex::fits(std::uint32_t cells) const {
    const double wide = highX_ - lowX_, high = highY_ - lowY_;
    double entries = 0.0;
    for (const auto& edge : edges_) {
        const double across = wide > 0.0 ? (edge.high - edge.low) / wide : 0.0;
        entries += 2.0 + cells * (across + (edge.by - edge.ay) / high);
    }
    return entries <= static_cast<double>(mostEntries);
}

/// The cells of a row that an edge comes near to.
PolygonIndex::Span PolygonIndex::columnsOf(const Edge& edge, std::uint32_t row) const {
    const auto at = [&](double y) {
        const double share = std::clamp((y - edge.ay) / (edge.by - edge.ay), 0.0, 1.0);
        return edge.ax + (edge.bx - edge.ax) * share;
    };
    // A little more than the row's own share of the edge.
    const double from = at(lowY_ + (row - 1e-6) / scaleY_ - marginY_);
    const double to = at(lowY_ + (row + 1.0 + 1e-6) / scaleY_ + marginY_);
    return {column(std::min(from, to) - marginX_), column(std::max(from, to) + marginX_)};
}

void PolygonIndex::fill() {
    const std::size_t all = std::size_t{cells_} * cells_;
    parity_.assign(all, 0);
    begin_.assign(all + 1, 0);
    // Twice over the same: how many entries each cell has, then the entries.
    const auto visit = [&](auto&& enter, auto&& right) {
        for (std::size_t i = 0; i < edges_.size(); ++i) {
            const auto& edge = edges_[i];
            const auto first = row(edge.ay), last = row(edge.by);
            for (auto r = first; r <= last; ++r) {
                const auto span = columnsOf(edge, r);
                for (auto c = span.first; c <= span.last; ++c) enter(std::size_t{r} * cells_ + c, i);
                // Its end below counts in every row above its own, its upper end in none that it reaches.
                if (r > first) right(r, span.first);
            }
        }
        for (std::size_t i = 0; i < joints_.size(); ++i) {
            const auto& joint = joints_[i];
            const auto r = row(joint.y);
            const auto a = columnsOf(edges_[joint.first], r).first;
            const auto b = columnsOf(edges_[joint.second], r).first;
            for (auto c = std::min(a, b); c < std::max(a, b); ++c)
                enter(std::size_t{r} * cells_ + c, edges_.size() + i);
        }
    };
    visit([&](std::size_t cell, std::size_t) { ++begin_[cell + 1]; },
          [&](std::uint32_t r, std::uint32_t end) {
              if (end > 0) parity_[std::size_t{r} * cells_ + end - 1] ^= 1U;
          });
    for (std::size_t i = 0; i < all; ++i) begin_[i + 1] += begin_[i];
    entries_.resize(begin_[all]);
    auto next = begin_;
    visit([&](std::size_t cell,
              std::size_t entry) { entries_[next[cell]++] = static_cast<std::uint32_t>(entry); },
          [](std::uint32_t, std::uint32_t) {});
    for (std::uint32_t r = 0; r < cells_; ++r) {
        for (auto c = cells_ - 1; c > 0; --c)
            parity_[std::size_t{r} * cells_ + c - 1] ^= parity_[std::size_t{r} * cells_ + c];
    }
}

bool PolygonIndex::counts(const Edge& edge, double x, double y) const {
    if (!(edge.ay <= y && y < edge.by)) return false;
    const double at = edge.ax + (edge.bx - edge.ax) * ((y - edge.ay) / (edge.by - edge.ay));
    return x < std::clamp(at, edge.low, edge.high);
}

bool PolygonIndex::contains(double x, double y) const {
    if (!(x >= lowX_ && x < highX_ && y >= lowY_ && y < highY_)) return false;
    const std::size_t cell = std::size_t{row(y)} * cells_ + column(x);
    bool within = parity_[cell] != 0;
    for (auto i = begin_[cell]; i < begin_[cell + 1]; ++i) {
        const auto entry = entries_[i];
        if (entry < edges_.size())
            within ^= counts(edges_[entry], x, y);
        else
            within ^= joints_[entry - edges_.size()].y <= y;
    }
    return within;
}

std::uint64_t PolygonIndex::bytes() const {
    return edges_.capacity() * sizeof(Edge) + joints_.capacity() * sizeof(Joint) + parity_.capacity() +
           (begin_.capacity() + entries_.capacity()) * sizeof(std::uint32_t);
}

}  // namespace mote::storage
