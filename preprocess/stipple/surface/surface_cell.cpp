// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/stipple/surface/surface_cell.h"

#include <array>
#include <glm/geometric.hpp>
#include <limits>

namespace mote::prep {
namespace {

constexpr std::uint32_t openEdge = UINT32_MAX;        // of the polygon that a cell is cut from
constexpr std::uint32_t borderEdge = UINT32_MAX - 1;  // on a border of the surface

/// How far around a point is looked, in spacings, one after the other. Of the cells of a good distribution
/// six in seven need no more than the first.
constexpr std::array<double, 3> radii{1.5, 2.1, 3.2};

/// What a cell is cut from, an octagon around a circle of radius 1. Its sides lie at half the radius that is
/// looked around: what is further off than the radius cannot cut it there.
constexpr double near = 0.41421356237309503;  // tan(pi / 8)
constexpr std::array<glm::dvec2, 8> octagon{
    {{1, -near}, {1, near}, {near, 1}, {-near, 1}, {-1, near}, {-1, -near}, {-near, -1}, {near, -1}}};

/// Arc over chord where the normal turns by an angle of this cosine: (a/2) / sin(a/2).
double arcOverChord(double cosine) {
    const double s = 0.5 * (1.0 - std::clamp(cosine, -1.0, 1.0));  // sin^2 of half of it
    return 1.0 + s * (1.0 / 6.0 + s * (3.0 / 40.0 + s * (5.0 / 112.0 + s * (35.0 / 1152.0))));
}

double cross(const glm::dvec2& a, const glm::dvec2& b) {
    return a.x * b.y - a.y * b.x;
}

/// Keeps the part of a convex polygon where dot(place, normal) <= offset; the new side has the mark `edge`.
/// Returns how far its furthest corner lies off.
template <class Corner>
double cut(std::vector<Corner>& polygon, std::vector<Corner>& kept, const glm::dvec2& normal, double offset,
           std::uint32_t edge) {
    kept.clear();
    double most = 0.0;
    const auto keep = [&](const Corner& corner) {
        most = std::max(most, glm::dot(corner.place, corner.place));
        kept.push_back(corner);
    };
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const auto& a = polygon[i];
        const auto& b = polygon[i + 1 < polygon.size() ? i + 1 : 0];
        const double atA = glm::dot(a.place, normal) - offset;
        const double atB = glm::dot(b.place, normal) - offset;
        if (atA <= 0.0) keep(a);
        if ((atA <= 0.0) == (atB <= 0.0)) continue;
        const auto crossing = a.place + (atA / (atA - atB)) * (b.place - a.place);
        keep({crossing, atA <= 0.0 ? edge : a.edge});
    }
    polygon.swap(kept);
    return std::sqrt(most);
}

}  // namespace

void CellScratch::supposeNothing() {
    supposed_.clear();
    if (++supposition_ != 0) return;
    std::fill(supposedIn_.begin(), supposedIn_.end(), 0U);
    supposition_ = 1;
}

void CellScratch::suppose(std::uint32_t point, const SurfacePoint& place, const glm::vec3& normal) {
    supposedIn_[point] = supposition_;
    supposed_.push_back({point, place, normal});
}

const CellScratch::Supposed* CellScratch::findSupposed(std::uint32_t point) const {
    const auto found = std::find_if(supposed_.rbegin(), supposed_.rend(),
                                    [&](const auto& one) { return one.point == point; });
    return &*found;
}

SurfaceCells::Frame SurfaceCells::frameAt(std::uint32_t point, const CellScratch& scratch) const {
    const auto* const moved = scratch.supposed(point);
    const auto& place = moved ? moved->place : set_.points[point];
    const auto normal = glm::dvec3(moved ? moved->normal : set_.normals[point]);
    const auto across = std::abs(normal.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const auto x = glm::normalize(glm::cross(across, normal));
    return {place.position, normal, x, glm::cross(normal, x), place.triangle};
}

void SurfaceCells::beginWalk(const Frame& frame, CellScratch& scratch) {
    scratch.round_ += 2;
    if (scratch.round_ == 0) {
        std::fill(scratch.visited_.begin(), scratch.visited_.end(), 0U);
        scratch.round_ = 2;
    }
    scratch.borders_.clear();
    scratch.beyond_.clear();
    scratch.front_.assign(1, frame.triangle);
    scratch.visited_[frame.triangle] = scratch.round_;
}

/// Marks the triangles that the surface leads to from the point's own, within the radius and before it has
/// turned out of sight, and notes the borders among them. Goes on from where the last radius ended.
void SurfaceCells::walkAround(const Frame& frame, double radius, CellScratch& scratch) const {
    const glm::vec3 origin(frame.origin);
    const auto reaches = [&](const WalkMesh::Facet& facet) {
        const auto off = facet.center - origin;
        const float reachable = static_cast<float>(radius) + facet.radius;
        return glm::dot(off, off) <= reachable * reachable;
    };
    auto* const visited = scratch.visited_.data();
    const auto round = scratch.round_;
    std::erase_if(scratch.beyond_, [&](std::uint32_t t) {
        if (!reaches(mesh_.facet(t))) return false;
        visited[t] = round;
        scratch.front_.push_back(t);
        return true;
    });
    const glm::vec3 normal(frame.normal);
    const auto leastCosine = static_cast<float>(borderCosine);
    while (!scratch.front_.empty()) {
        const auto t = scratch.front_.back();
        scratch.front_.pop_back();
        const auto& neighbours = mesh_.facet(t).neighbours;
        for (std::uint32_t side = 0; side < 3; ++side) {
            const auto next = neighbours[side];
            if (next == WalkMesh::none) {
                noteBorder(frame, t, side, scratch);
                continue;
            }
            if (visited[next] >= round) continue;
            const auto& facet = mesh_.facet(next);
            visited[next] = round + 1;  // seen, but not within
            if (glm::dot(normal, facet.normal) < leastCosine) continue;
            if (reaches(facet)) {
                visited[next] = round;
                scratch.front_.push_back(next);
            } else {
                scratch.beyond_.push_back(next);
            }
        }
    }
    std::sort(scratch.borders_.begin(), scratch.borders_.end(),
              [](const auto& a, const auto& b) { return a.distance < b.distance; });
}

void SurfaceCells::noteBorder(const Frame& frame, std::uint32_t triangle, std::uint32_t side,
                              CellScratch& scratch) const {
    const auto flat = [&](const glm::dvec3& place) {
        const auto d = place - frame.origin;
        return glm::dvec2(glm::dot(d, frame.x), glm::dot(d, frame.y));
    };
    const auto a = flat(mesh_.corner(triangle, side));
    const auto b = flat(mesh_.corner(triangle, (side + 1) % 3));
    const auto along = b - a;
    const double length = std::max(glm::dot(along, along), 1e-300);
    const double share = std::clamp(-glm::dot(a, along) / length, 0.0, 1.0);
    scratch.borders_.push_back({a, b, glm::length(a + share * along)});
}

/// Brings the points on the marked triangles into the plane, the nearest first.
void SurfaceCells::look(const Frame& frame, std::uint32_t point, std::uint32_t without, double radius,
                        CellScratch& scratch) const {
    scratch.seen_.clear();
    set_.grid.near(frame.origin, radius, [&](std::uint32_t other) {
        if (other == point || other == without) return;
        const auto* const moved = scratch.supposed(other);
        const auto& place = moved ? moved->place : set_.points[other];
        const auto d = place.position - frame.origin;
        const double chord2 = glm::dot(d, d);
        if (chord2 > radius * radius || scratch.visited_[place.triangle] != scratch.round_) return;
        const double turn = glm::dot(frame.normal, glm::dvec3(moved ? moved->normal : set_.normals[other]));
        if (turn < borderCosine) return;
        const double chord = std::sqrt(chord2);
        const glm::dvec2 direction(glm::dot(d, frame.x), glm::dot(d, frame.y));
        const double flat = glm::length(direction);
        const double length = chord * arcOverChord(turn);
        // One right above has no direction, and one at the same place no distance: any will do.
        const auto at =
            flat > 1e-6 * chord && flat > 0.0 ? direction * (length / flat) : glm::dvec2(length, 0);
        const double flatness = chord > 0.0 ? std::min(turn, flat / chord) : turn;
        scratch.seen_.push_back({at, length, other, static_cast<float>(flatness)});
    });
    std::sort(scratch.seen_.begin(), scratch.seen_.end(), [](const auto& a, const auto& b) {
        return a.distance != b.distance ? a.distance < b.distance : a.point < b.point;
    });
}

/// Cuts the cell out of a polygon around the point. False where something beyond the radius might cut it,
/// too.
bool SurfaceCells::clip(double radius, CellScratch& scratch) const {
    auto& polygon = scratch.polygon_;
    polygon.clear();
    for (const auto& corner : octagon) polygon.push_back({0.5 * radius * corner, openEdge});
    double most = 0.5 * radius * glm::length(octagon[0]);
    for (std::size_t i = 0; i < scratch.seen_.size(); ++i) {
        const auto& seen = scratch.seen_[i];
        if (seen.distance > 2.0 * most) break;
        const bool again = i > 0 && scratch.seen_[i - 1].point == seen.point;
        if (again || seen.distance <= 0.0) continue;
        most = cut(polygon, scratch.clipped_, seen.place / seen.distance, 0.5 * seen.distance, seen.point);
    }
    for (const auto& border : scratch.borders_) {
        if (border.distance > most || polygon.size() < 3) break;
        auto outward = glm::dvec2(border.b.y - border.a.y, border.a.x - border.b.x);
        const double length = glm::length(outward);
        if (!(length > 0.0)) continue;
        outward /= length;
        // Seen from outside, as the far side of a hole: what lies this side of it has cut already.
        double offset = glm::dot(outward, border.a);
        if (offset < -1e-3 * set_.spacing) continue;
        offset = std::max(offset, 0.0);
        // Only where the border itself, and not what continues its line, meets the cell.
        const auto along = glm::dvec2(-outward.y, outward.x);
        const double from = glm::dot(along, border.a);
        const double to = glm::dot(along, border.b);
        const double nearest = std::clamp(0.0, std::min(from, to), std::max(from, to));
        const double limit = most * most - offset * offset;
        if (nearest * nearest > limit) continue;
        most = cut(polygon, scratch.clipped_, outward, offset, borderEdge);
    }
    const bool open = std::any_of(polygon.begin(), polygon.end(),
                                  [](const auto& corner) { return corner.edge == openEdge; });
    return !open && 2.0 * most <= radius;
}

void SurfaceCells::measure(const Frame& frame, CellScratch& scratch, SurfaceCell& cell) const {
    const auto& polygon = scratch.polygon_;
    cell.neighbours.clear();
    cell.atBorder = false;
    double area = 0.0;
    double moment = 0.0;
    glm::dvec2 sum(0.0);
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const auto& a = polygon[i].place;
        const auto& b = polygon[i + 1 < polygon.size() ? i + 1 : 0].place;
        const double twice = cross(a, b);
        area += 0.5 * twice;
        sum += (twice / 6.0) * (a + b);
        moment += (twice / 12.0) * (glm::dot(a, a) + glm::dot(a, b) + glm::dot(b, b));
        const auto edge = polygon[i].edge;
        cell.atBorder = cell.atBorder || edge == borderEdge;
        if (edge < borderEdge) cell.neighbours.push_back(edge);
    }
    cell.area = std::max(area, 0.0);
    cell.moment = std::max(moment, 0.0);
    cell.toCentroid = glm::dvec3(0.0);
    if (area > 0.0) cell.toCentroid = (sum.x / area) * frame.x + (sum.y / area) * frame.y;
    cell.nearest = std::numeric_limits<double>::infinity();
    cell.nearestPoint = none;
    if (scratch.seen_.empty()) return;
    cell.nearest = scratch.seen_.front().distance;
    cell.nearestPoint = scratch.seen_.front().point;
}

void SurfaceCells::find(std::uint32_t point, std::uint32_t without, CellScratch& scratch,
                        SurfaceCell& cell) const {
    const auto frame = frameAt(point, scratch);
    bool closed = false;
    beginWalk(frame, scratch);
    for (std::size_t i = 0; i < radii.size() && !closed; ++i) {
        const double radius = radii[i] * set_.spacing;
        walkAround(frame, radius, scratch);
        look(frame, point, without, radius, scratch);
        closed = clip(radius, scratch);
    }
    measure(frame, scratch, cell);
    cell.closed = closed;
    cell.flat = closed;
    for (const auto& seen : scratch.seen_) {
        if (seen.flatness >= flatEnough) continue;
        const bool touches =
            std::find(cell.neighbours.begin(), cell.neighbours.end(), seen.point) != cell.neighbours.end();
        if (touches) cell.flat = false;
    }
}

}  // namespace mote::prep
