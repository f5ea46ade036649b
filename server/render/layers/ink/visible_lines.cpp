// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/mesh_lines.h"

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <span>
#include <stop_token>
#include <vector>

#include "server/render/ink/tone_grid.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

/// A straight line on the screen. `nearness` is linear along it and greater for what is nearer.
struct ScreenLine {
    glm::dvec2 from{0.0}, to{0.0};  ///< pixels from the picture's upper left corner
    double nearnessFrom = 0.0, nearnessTo = 0.0;
};

/// Tells where lines pass in front of one another on the screen. What is seen of a line changes there, or
/// where surfaces go through each other (Appel 1967, The notion of quantitative invisibility). Made for a
/// view, immutable; any number of threads may ask.
class LineCrossings {
  public:
    /// `margin`: pixels beside the picture up to which lines are of interest.
    LineCrossings(std::vector<ScreenLine> lines, std::uint32_t width, std::uint32_t height, double margin,
                  const std::stop_token& stop);

    /// Fills `shares` with the places of a line, 0 to 1 on the screen, in order, where a nearer one crosses
    /// it.
    void along(const ScreenLine& line, std::vector<double>& shares) const;

  private:
    /// In squares of the grid.
    ScreenLine onGrid(const ScreenLine& line) const;

    std::vector<ScreenLine> lines_;
    double margin_;
    std::uint32_t columns_, rows_;
    std::vector<std::uint32_t> begins_;  // of each square's lines; one more than squares
    std::vector<std::uint32_t> inside_;  // numbers of lines
};

constexpr double square = 4.0;  // pixels
// Lines in a square: if there are more, each is shorter than what is told apart, and none is compared.
constexpr std::uint32_t crowd = 4096;

double area(const glm::dvec2& a, const glm::dvec2& b) {
    return a.x * b.y - a.y * b.x;
}

/// The share of a line at which a nearer one crosses it; below 0 if none does.
double crossing(const ScreenLine& line, const ScreenLine& other) {
    const glm::dvec2 way = line.to - line.from, otherWay = other.to - other.from,
                     off = other.from - line.from;
    const double turn = area(way, otherWay);
    if (turn == 0.0) return -1.0;
    const double share = area(off, otherWay) / turn, otherShare = area(off, way) / turn;
    if (!(share > 0.0 && share < 1.0 && otherShare >= 0.0 && otherShare <= 1.0)) return -1.0;
    const double here = std::lerp(line.nearnessFrom, line.nearnessTo, share);
    const double there = std::lerp(other.nearnessFrom, other.nearnessTo, otherShare);
    return there > here ? share : -1.0;
}

LineCrossings::LineCrossings(std::vector<ScreenLine> lines, std::uint32_t width, std::uint32_t height,
                             double margin, const std::stop_token& stop)
    : lines_(std::move(lines)),
      margin_(margin),
      columns_(static_cast<std::uint32_t>(std::ceil((width + 2.0 * margin) / square))),
      rows_(static_cast<std::uint32_t>(std::ceil((height + 2.0 * margin) / square))),
      begins_(std::size_t{columns_} * rows_ + 1, 0) {
    const auto eachPlace = [&](const auto& take) {
        for (std::uint32_t i = 0; i < lines_.size() && !isStopped(stop); ++i) {
            const ScreenLine line = onGrid(lines_[i]);
            eachSquare(line.from, line.to, columns_, rows_,
                       [&](std::uint32_t column, std::uint32_t row, double) {
                           take(std::size_t{row} * columns_ + column, i);
                       });
        }
    };
    eachPlace([&](std::size_t at, std::uint32_t) { ++begins_[at + 1]; });
    std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
    inside_.resize(begins_.back());
    auto next = begins_;
    eachPlace([&](std::size_t at, std::uint32_t i) {
        if (next[at] < begins_[at + 1]) inside_[next[at]++] = i;
    });
}

ScreenLine LineCrossings::onGrid(const ScreenLine& line) const {
    return {(line.from + margin_) / square, (line.to + margin_) / square, 0.0, 0.0};
}

void LineCrossings::along(const ScreenLine& line, std::vector<double>& shares) const {
    shares.clear();
    const ScreenLine placed = onGrid(line);
    eachSquare(placed.from, placed.to, columns_, rows_, [&](std::uint32_t column, std::uint32_t row, double) {
        const std::size_t at = std::size_t{row} * columns_ + column;
        if (begins_[at + 1] - begins_[at] > crowd) return;
        for (auto i = begins_[at]; i < begins_[at + 1]; ++i) {
            const double share = crossing(line, lines_[inside_[i]]);
            if (share >= 0.0) shares.push_back(share);
        }
    });
    std::sort(shares.begin(), shares.end());
}

constexpr double smallestStep = 1.0 / 64;  // pixels; of what is hidden, at least so much is passed by
// Of the bounds' diagonal: what lies so little nearer than a line does not hide it.
constexpr double touchShare = 1e-7;
// Likewise: what is nearer by so much is another part of the surface.
constexpr double behindShare = 1e-2;

/// Of what lies in front of the eye.
ScreenLine onScreen(const Ends& ends, const LineView& view) {
    const auto nearness = [&](const glm::dvec3& at) { return view.perspective() ? -1.0 / at.z : at.z; };
    return {view.onScreen(ends.from), view.onScreen(ends.to), nearness(ends.from), nearness(ends.to)};
}

/// What is seen of some edges after another; one thread's.
class PieceFinder {
  public:
    PieceFinder(const MeshSurface& surface, const LineView& view, const LineCrossings& crossings,
                const HiderSearch& search)
        : surface_(surface),
          view_(view),
          crossings_(crossings),
          search_(search),
          gap_(touchShare * glm::length(surface.bounds().size())) {}

    void find(std::span<const EdgeLine> edges, std::vector<EdgeLine>& pieces, const std::stop_token& stop) {
        tried_.clear();
        covered_.assign(edges.size(), {});
        for (std::uint32_t i = 0; i < edges.size() && !isStopped(stop); ++i) choosePlaces(edges[i], i);
        tryPlaces(edges, stop);
        auto next = tried_.begin();
        for (std::uint32_t i = 0; i < edges.size() && !isStopped(stop); ++i) {
            const Ends ends = endsOf(surface_, edges[i], view_);
            hidden_ = std::move(covered_[i]);
            seen_.clear();
            for (; next != tried_.end() && next->edge == i; ++next) take(*next, ends);
            settleAll(edges[i], ends, pieces);
        }
    }

  private:
    /// What lies between hidden parts, parted where nearer lines cross it.
    void settleParts(const EdgeLine& edge, const Ends& ends, const Span& gap, std::vector<EdgeLine>& pieces) {
        if (crossed_.empty()) cross(edge, ends);
        double begin = gap.begin;
        for (auto at = std::upper_bound(crossed_.begin(), crossed_.end(), gap.begin);
             at != crossed_.end() && *at < gap.end; ++at) {
            settle(edge, ends, {begin, *at}, pieces);
            begin = *at;
        }
        settle(edge, ends, {begin, gap.end}, pieces);
    }
    /// Where nearer lines cross an edge, with its ends.
    void cross(const EdgeLine& edge, const Ends& ends) {
        const auto [begin, end] = edge.piece;
        const Ends part = partOf(ends, edge.piece);
        crossings_.along(onScreen(part, view_), crossed_);
        for (auto& share : crossed_)
            share = begin + (end - begin) * view_.alongLine(part.from, part.to, share);
        crossed_.push_back(end);
    }
    /// Of a part within which nothing changes but by what is narrow: it is seen where a place of it is.
    void settle(const EdgeLine& edge, const Ends& ends, const Span& gap, std::vector<EdgeLine>& pieces) {
        gaps_.assign(1, gap);
        while (!gaps_.empty()) {
            const auto [begin, end] = gaps_.back();
            gaps_.pop_back();
            if (!(begin < end)) continue;
            const auto seen = std::lower_bound(seen_.begin(), seen_.end(), begin);
            const bool known = seen != seen_.end() && *seen <= end;
            if (!known && narrow(ends, {begin, end})) {
                if (follows(pieces, begin)) pieces.back().piece.end = end;
                continue;
            }
            const Span span = known ? Span{} : soughtAt(edge, ends, 0.5 * (begin + end));
            if (span.empty()) {
                take(edge, {begin, end}, pieces);
                continue;
            }
            gaps_.push_back({span.end, end});
            gaps_.push_back({begin, span.begin});
        }
    }
    /// Whether the edge's last piece ends there.
    bool follows(const std::vector<EdgeLine>& pieces, double begin) const {
        return pieces.size() > own_ && pieces.back().piece.end == begin;
    }
    void take(const EdgeLine& edge, const Span& span, std::vector<EdgeLine>& pieces) const {
        if (follows(pieces, span.begin)) {
            pieces.back().piece.end = span.end;
            return;
        }
        pieces.push_back(edge);
        pieces.back().piece = span;
    }
    bool narrow(const Ends& ends, const Span& gap) const {
        const glm::dvec3 way = ends.to - ends.from;
        return glm::distance(view_.onScreen(ends.from + gap.begin * way),
                             view_.onScreen(ends.from + gap.end * way)) < smallestStep;
    }
    /// Places all along an edge, but where the triangle that is seen there hides it.
    void choosePlaces(const EdgeLine& edge, std::uint32_t number) {
        // The whole edge may reach behind the eye, where places on the screen have no order.
        const auto [begin, end] = edge.piece;
        const Ends ends = endsOf(surface_, edge, view_);
        const auto [from, to] = partOf(ends, edge.piece);
        const double length = glm::distance(view_.onScreen(from), view_.onScreen(to));
        const double count = std::max(1.0, std::ceil(length / search_.sampling));
        hidden_.clear();
        for (double place = 0.5; place < count; ++place) {
            const double along = begin + (end - begin) * view_.alongLine(from, to, place / count);
            if (!hiddenAt(along).empty()) continue;
            const std::uint32_t likely = likelyHider(edge, ends.from + along * (ends.to - ends.from));
            if (likely == MeshMeeting::none)
                tried_.push_back({number, along, MeshMeeting::none});
            else
                hide(ends, along, likely);
        }
        covered_[number] = hidden_;
    }
    /// What hides the chosen places, many at a time.
    void tryPlaces(std::span<const EdgeLine> edges, const std::stop_token& stop) {
        std::array<MeshRay, MeshRays::packet> rays;
        std::array<IgnoredTriangles, MeshRays::packet> own;
        std::array<MeshMeeting, MeshRays::packet> met;
        for (std::size_t first = 0; first < tried_.size() && !isStopped(stop); first += rays.size()) {
            rays.fill({});
            const std::size_t count = std::min(rays.size(), tried_.size() - first);
            for (std::size_t i = 0; i < count; ++i) {
                const auto& place = tried_[first + i];
                const auto [from, to] = endsOf(surface_, edges[place.edge], view_);
                rays[i] = view_.fromEye(from + place.along * (to - from), gap_);
                rays[i].clip(surface_.rays().box());
                own[i] = edges[place.edge].triangles;
            }
            surface_.rays().firstBut(rays, own, met);
            for (std::size_t i = 0; i < count; ++i) tried_[first + i].hider = met[i].triangle;
        }
    }
    struct TriedPlace {
        std::uint32_t edge;
        double along;         // the edge
        std::uint32_t hider;  // or none
    };
    void take(const TriedPlace& place, const Ends& ends) {
        if (!hiddenAt(place.along).empty()) return;
        if (place.hider == MeshMeeting::none)
            seen_.push_back(place.along);
        else
            hide(ends, place.along, place.hider);
    }
    void settleAll(const EdgeLine& edge, const Ends& ends, std::vector<EdgeLine>& pieces) {
        std::sort(hidden_.begin(), hidden_.end(),
                  [](const Span& a, const Span& b) { return a.begin < b.begin; });
        const std::vector<Span> hidden = hidden_;
        crossed_.clear();
        own_ = pieces.size();
        double begin = edge.piece.begin;
        for (const Span& span : hidden) {
            if (begin < span.begin) settleParts(edge, ends, {begin, span.begin}, pieces);
            begin = std::max(begin, span.end);
        }
        if (begin < edge.piece.end) settleParts(edge, ends, {begin, edge.piece.end}, pieces);
    }
    Span hiddenAt(double along) const {
        for (const Span& span : hidden_) {
            if (span.begin <= along && along <= span.end) return span;
        }
        return {};
    }
    Span soughtAt(const EdgeLine& edge, const Ends& ends, double along) {
        const std::uint32_t triangle = hider(edge, ends.from + along * (ends.to - ends.from));
        return triangle == MeshMeeting::none ? Span{} : hide(ends, along, triangle);
    }
    /// What of an edge a triangle hides around a place.
    Span hide(const Ends& ends, double along, std::uint32_t triangle) {
        const auto& mesh = surface_.mesh();
        const auto [i, j, k] = mesh.triangles[triangle];
        Span span = view_.hidden(
            ends.from, ends.to,
            {view_.toEye(mesh.positions[i]), view_.toEye(mesh.positions[j]), view_.toEye(mesh.positions[k])});
        if (span.empty()) span = {along, along};
        span = {std::min(span.begin, along), std::max(span.end, along)};
        hidden_.push_back(span);
        return span;
    }

    /// A triangle that hides a place of the edge, in eye space.
    std::uint32_t hider(const EdgeLine& edge, const glm::dvec3& place) const {
        const std::uint32_t likely = likelyHider(edge, place);
        if (likely != MeshMeeting::none) return likely;
        auto ray = view_.towardsEye(place, gap_);
        ray.clip(surface_.rays().box());
        return surface_.rays().firstBut(ray, edge.triangles).triangle;
    }
    /// The same, if it is the one that is seen in the pixel.
    std::uint32_t likelyHider(const EdgeLine& edge, const glm::dvec3& place) const {
        const std::uint32_t likely = likelyAt(view_.onScreen(place));
        if (likely == MeshMeeting::none || likely == edge.triangles[0] || likely == edge.triangles[1])
            return MeshMeeting::none;
        auto ray = view_.towardsEye(place, gap_);
        ray.clip(surface_.rays().box());
        return !ray.empty() && meet(surface_.mesh(), likely, ray) ? likely : MeshMeeting::none;
    }
    std::uint32_t likelyAt(const glm::dvec2& place) const {
        if (search_.likely == nullptr) return MeshMeeting::none;
        return search_.likely->near(place.x, place.y);
    }

    const MeshSurface& surface_;
    const LineView& view_;
    const LineCrossings& crossings_;
    const HiderSearch search_;
    const double gap_;
    std::vector<Span> hidden_;                // of the edge
    std::vector<double> seen_;                // places of it, in order
    std::vector<double> crossed_;             // places of it, in order; empty while they are not known
    std::size_t own_ = 0;                     // pieces before its own
    std::vector<TriedPlace> tried_;           // of all edges, in order
    std::vector<std::vector<Span>> covered_;  // hidden by what is seen, of each edge
    std::vector<Span> gaps_;  // of which it is not known whether they are seen, the next one last
};

/// Of each pixel and those around it.
Raster<float> greatestAround(const Raster<float>& picture) {
    const auto along = [](const Raster<float>& of, bool down) {
        Raster<float> made(of.width, of.height);
        forInTurns(std::uint32_t{0}, of.height, [&](std::uint32_t row) {
            for (std::uint32_t column = 0; column < of.width; ++column) {
                const std::uint32_t here = down ? row : column, last = (down ? of.height : of.width) - 1;
                const std::uint32_t before = here > 0 ? here - 1 : 0, next = std::min(here + 1, last);
                const auto value = [&](std::uint32_t at) {
                    return down ? of.at(column, at) : of.at(at, row);
                };
                made.at(column, row) = std::max({value(before), value(here), value(next)});
            }
        });
        return made;
    };
    return along(along(picture, false), true);
}

/// Edges but for those that lie behind everything that is seen around them: neither are they seen, nor
/// anything behind them. `farthest`: of HiderSearch.
std::vector<EdgeLine> inSight(const MeshSurface& surface, const LineView& view,
                              const std::vector<EdgeLine>& edges, const Raster<float>* farthest,
                              const std::stop_token& stop) {
    if (farthest == nullptr) return edges;
    const auto around = greatestAround(*farthest);
    const double gap = behindShare * view.scale() * glm::length(surface.bounds().size());
    const auto behind = [&](const EdgeLine& edge) {
        const auto [from, to] = partOf(endsOf(surface, edge, view), edge.piece);
        const double parts = std::ceil(glm::distance(view.onScreen(from), view.onScreen(to))) + 1.0;
        for (double part = 0.0; part <= parts; ++part) {
            const glm::dvec3 place = from + view.alongLine(from, to, part / parts) * (to - from);
            const glm::dvec2 at = view.onScreen(place);
            if (!(static_cast<double>(around.near(at.x, at.y)) < -place.z - gap)) return false;
        }
        return true;
    };
    return inOrder<EdgeLine>(edges.size(), stop, [&](std::size_t first, std::size_t last, auto& kept) {
        std::copy_if(edges.begin() + static_cast<std::ptrdiff_t>(first),
                     edges.begin() + static_cast<std::ptrdiff_t>(last), std::back_inserter(kept),
                     [&](const EdgeLine& edge) { return !behind(edge); });
    });
}

/// Of lines behind which something may be hidden: a surface ends there for the eye.
LineCrossings crossingsOf(const MeshSurface& surface, const LineView& view,
                          const std::vector<EdgeLine>& edges, const std::stop_token& stop) {
    std::vector<ScreenLine> lines;
    lines.reserve(edges.size());
    for (const auto& edge : edges) {
        if (edge.kind != LineKind::crease && edge.kind != LineKind::suggestive)
            lines.push_back(onScreen(partOf(endsOf(surface, edge, view), edge.piece), view));
    }
    const auto width = static_cast<std::uint32_t>(view.size().x),
               height = static_cast<std::uint32_t>(view.size().y);
    return {std::move(lines), width, height, lineMargin, stop};
}

}  // namespace

std::vector<EdgeLine> visible(const MeshSurface& surface, const LineView& view,
                              const std::vector<EdgeLine>& edges, const HiderSearch& search,
                              const std::stop_token& stop) {
    const auto near = inSight(surface, view, edges, search.farthest, stop);
    const auto crossings = crossingsOf(surface, view, near, stop);
    return inOrder<EdgeLine>(near.size(), stop, [&](std::size_t first, std::size_t last, auto& pieces) {
        PieceFinder(surface, view, crossings, search)
            .find(std::span(near).subspan(first, last - first), pieces, stop);
    });
}

}  // namespace mote::render
