// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/mix.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>

namespace mote {
namespace {

/// A unit vector at a right angle to one.
glm::dvec3 acrossFrom(const glm::dvec3& unit) {
    const bool alongX = std::abs(unit.x) > 0.9;
    const glm::dvec3 other = alongX ? glm::dvec3(0.0, 1.0, 0.0) : glm::dvec3(1.0, 0.0, 0.0);
    return glm::normalize(glm::cross(unit, other));
}

}  // namespace

glm::dvec3 mixDirections(const glm::dvec3& from, const glm::dvec3& to, double share) {
    if (from == to || share <= 0.0) return from;
    if (share >= 1.0) return to;
    const glm::dvec3 aside = to - glm::dot(from, to) * from;
    const double sine = glm::length(aside), cosine = glm::dot(from, to);
    const double angle = share * std::atan2(sine, cosine);
    const glm::dvec3 across = sine > 1e-9 ? aside / sine : acrossFrom(from);
    return glm::normalize(std::cos(angle) * from + std::sin(angle) * across);
}

namespace {

using Knots = std::vector<Curve::Knot>;

constexpr std::size_t mostKnots = 256;  // Curve::create

/// A place on a curve: at a share of the way from one knot to the next.
struct Place {
    std::size_t knot;
    double share;
};

/// What holds just below x: of a step, its foot.
Place below(const Knots& knots, double x) {
    const auto next = std::lower_bound(knots.begin(), knots.end(), x,
                                       [](const auto& knot, double v) { return knot.x < v; });
    if (next == knots.begin()) return {0, 0.0};
    if (next == knots.end()) return {knots.size() - 1, 0.0};
    const auto before = next - 1;
    return {static_cast<std::size_t>(before - knots.begin()), (x - before->x) / (next->x - before->x)};
}

/// What holds at x and just above it: of a step, its head.
Place above(const Knots& knots, double x) {
    const auto next = std::upper_bound(knots.begin(), knots.end(), x,
                                       [](double v, const auto& knot) { return v < knot.x; });
    if (next == knots.begin()) return {0, 0.0};
    const auto before = static_cast<std::size_t>(next - knots.begin()) - 1;
    if (next == knots.end()) return {before, 0.0};
    return {before, (x - knots[before].x) / (next->x - knots[before].x)};
}

double opacityAt(const ColoredCurve& curve, const Place& place) {
    const auto& knots = curve.curve.knots();
    return place.share > 0.0 ? mix(knots[place.knot].y, knots[place.knot + 1].y, place.share)
                             : knots[place.knot].y;
}

glm::dvec3 colorAt(const ColoredCurve& curve, const Place& place) {
    const auto& colors = curve.colors;
    return place.share > 0.0 ? mix(colors[place.knot], colors[place.knot + 1], place.share)
                             : colors[place.knot];
}

bool stepsAt(const Knots& knots, double x) {
    const auto same = std::equal_range(knots.begin(), knots.end(), Curve::Knot{x, 0.0},
                                       [](const auto& a, const auto& b) { return a.x < b.x; });
    return same.second - same.first > 1;
}

/// The x of all knots of both, each once; where one of them makes a step, twice.
std::vector<double> placesOfBoth(const Knots& a, const Knots& b) {
    std::vector<double> all;
    for (const auto& knot : a) all.push_back(knot.x);
    for (const auto& knot : b) all.push_back(knot.x);
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    std::vector<double> places;
    for (const double x : all) places.insert(places.end(), stepsAt(a, x) || stepsAt(b, x) ? 2 : 1, x);
    return places;
}

/// Both with knots at the same places, so that they can be mixed knot by knot.
ColoredCurve withKnotsAt(const ColoredCurve& curve, const std::vector<double>& places) {
    Knots knots;
    std::vector<glm::dvec3> colors;
    for (std::size_t i = 0; i < places.size(); ++i) {
        const bool foot = i + 1 < places.size() && places[i + 1] == places[i];
        const auto place =
            foot ? below(curve.curve.knots(), places[i]) : above(curve.curve.knots(), places[i]);
        knots.push_back({places[i], opacityAt(curve, place)});
        if (!curve.colors.empty()) colors.push_back(colorAt(curve, place));
    }
    return {Curve::create(std::move(knots), -Curve::largest, Curve::largest).value(), std::move(colors)};
}

ColoredCurve mixKnots(const ColoredCurve& from, const ColoredCurve& to, double share) {
    Knots knots;
    std::vector<glm::dvec3> colors;
    for (std::size_t i = 0; i < from.curve.knots().size(); ++i) {
        const auto &a = from.curve.knots()[i], &b = to.curve.knots()[i];
        knots.push_back({mix(a.x, b.x, share), mix(a.y, b.y, share)});
        if (!from.colors.empty()) colors.push_back(mix(from.colors[i], to.colors[i], share));
    }
    return {Curve::create(std::move(knots), -Curve::largest, Curve::largest).value(), std::move(colors)};
}

}  // namespace

bool canMix(const ColoredCurve& from, const ColoredCurve& to) {
    if (from.colors.empty() != to.colors.empty()) return false;
    const auto &a = from.curve.knots(), &b = to.curve.knots();
    return a.size() == b.size() || placesOfBoth(a, b).size() <= mostKnots;
}

ColoredCurve mixCurves(const ColoredCurve& from, const ColoredCurve& to, double share) {
    const auto &a = from.curve.knots(), &b = to.curve.knots();
    if (a.size() == b.size()) return mixKnots(from, to, share);
    const auto places = placesOfBoth(a, b);
    return mixKnots(withKnotsAt(from, places), withKnotsAt(to, places), share);
}

}  // namespace mote
