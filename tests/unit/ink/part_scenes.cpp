// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/ink/part_scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <optional>
#include <vector>

#include "protocol/scene/light.h"

namespace mote::test {
namespace {

using render::Modalities;
using render::Raster;

constexpr double focal = 1.4;  // of the picture's height
constexpr double fine = 0.08;  // a pattern's period, some six of 360 rows
constexpr std::array<glm::dvec2, 4> places{
    {{-0.125, -0.375}, {0.375, -0.125}, {-0.375, 0.125}, {0.125, 0.375}}};

struct Ray {
    glm::dvec3 origin, direction;

    glm::dvec3 at(double t) const { return origin + t * direction; }
};

struct Hit {
    double t = HUGE_VAL;
    glm::dvec3 normal{0.0};
    std::uint32_t face = 0;

    void take(const Hit& other) {
        if (other.t > 0.0 && other.t < t) *this = other;
    }
};

enum class Shape { box, ball, cylinder, cone, ring };
enum class Pattern { none, waves, checks, noise };

/// Around its own axes: a box's half sides, or a radius, half a height (of rings: the tube's radius).
struct Solid {
    Shape shape;
    glm::dmat3 turn;
    glm::dvec3 middle, size;
    std::uint32_t firstPart;
    Pattern pattern = Pattern::none;
    double lean = 0.0;
};

Hit meetBox(const Ray& ray, const glm::dvec3& half) {
    double first = -HUGE_VAL, last = HUGE_VAL;
    int axis = 0;
    for (int i = 0; i < 3; ++i) {
        const double a = (-half[i] - ray.origin[i]) / ray.direction[i];
        const double b = (half[i] - ray.origin[i]) / ray.direction[i];
        if (std::min(a, b) > first) {
            first = std::min(a, b);
            axis = i;
        }
        last = std::min(last, std::max(a, b));
    }
    if (!(first < last)) return {};
    Hit hit{first};
    hit.normal[axis] = ray.direction[axis] > 0.0 ? -1.0 : 1.0;
    hit.face = static_cast<std::uint32_t>(2 * axis + (ray.direction[axis] > 0.0 ? 1 : 0));
    return hit;
}

/// The nearer and the farther root of a t^2 + 2 b t + c.
std::optional<std::array<double, 2>> roots(double a, double b, double c) {
    const double inside = b * b - a * c;
    if (!(inside > 0.0)) return std::nullopt;
    const double one = (-b - std::sqrt(inside)) / a, other = (-b + std::sqrt(inside)) / a;
    return std::array{std::min(one, other), std::max(one, other)};
}

Hit meetBall(const Ray& ray, double radius) {
    const auto t = roots(glm::dot(ray.direction, ray.direction), glm::dot(ray.origin, ray.direction),
                         glm::dot(ray.origin, ray.origin) - radius * radius);
    if (!t) return {};
    return {(*t)[0], ray.at((*t)[0]) / radius};
}

Hit meetDisc(const Ray& ray, double z, double radius, std::uint32_t face) {
    const double t = (z - ray.origin.z) / ray.direction.z;
    const auto at = ray.at(t);
    if (!(at.x * at.x + at.y * at.y <= radius * radius)) return {};
    return {t, {0.0, 0.0, z > 0.0 ? 1.0 : -1.0}, face};
}

/// Of a radius that goes from `bottom` at -half to `top` at half.
Hit meetTube(const Ray& ray, double bottom, double top, double half) {
    const double slope = (top - bottom) / (2.0 * half), middle = 0.5 * (bottom + top);
    const auto &o = ray.origin, &d = ray.direction;
    const double r = middle + slope * o.z, s = slope * d.z;
    const auto t =
        roots(d.x * d.x + d.y * d.y - s * s, o.x * d.x + o.y * d.y - r * s, o.x * o.x + o.y * o.y - r * r);
    Hit hit;
    if (t) {
        for (const double one : *t) {
            const auto at = ray.at(one);
            const glm::dvec3 out(at.x, at.y, -slope * (middle + slope * at.z));
            if (std::abs(at.z) <= half) hit.take({one, glm::normalize(out), 0});
        }
    }
    hit.take(meetDisc(ray, -half, bottom, 1));
    if (top > 0.0) hit.take(meetDisc(ray, half, top, 2));
    return hit;
}

/// By steps that are as long as the way to the surface.
Hit meetRing(const Ray& ray, double radius, double tube) {
    const double length = glm::length(ray.direction);
    const auto around = meetBall(ray, radius + tube);
    if (!(around.t > 0.0 && around.t < HUGE_VAL)) return {};
    for (double t = around.t, end = t + 2.0 * (radius + tube) / length; t < end;) {
        const auto at = ray.at(t);
        const double out = std::hypot(at.x, at.y);
        const double away = std::hypot(out - radius, at.z) - tube;
        if (away < 1e-6) {
            const glm::dvec3 core(at.x * radius / out, at.y * radius / out, 0.0);
            return {t, glm::normalize(at - core)};
        }
        t += away / length;
    }
    return {};
}

Hit meet(const Ray& ray, const Solid& solid) {
    const auto& size = solid.size;
    switch (solid.shape) {
        case Shape::box:
            return meetBox(ray, size);
        case Shape::ball:
            return meetBall(ray, size.x);
        case Shape::cylinder:
            return meetTube(ray, size.x, size.x, size.y);
        case Shape::cone:
            return meetTube(ray, size.x, 0.0, size.y);
        default:
            return meetRing(ray, size.x, size.y);
    }
}

/// By how much a normal leans at a place, -1 to 1.
glm::dvec3 leanAt(Pattern pattern, const glm::dvec3& at) {
    const glm::dvec3 cell = glm::floor(at * (2.0 / fine));
    switch (pattern) {
        case Pattern::waves: {
            const glm::dvec3 along(0.6, 0.64, 0.48);
            return along * std::cos(2.0 * std::numbers::pi / fine * glm::dot(along, at));
        }
        case Pattern::checks:
            return glm::dvec3(0.7, 0.5, -0.5) *
                   (std::fmod(std::abs(cell.x + cell.y + cell.z), 2.0) < 1.0 ? 1.0 : -1.0);
        case Pattern::noise: {
            Random random(static_cast<std::uint64_t>(
                static_cast<std::int64_t>(cell.x + 1000.0 * (cell.y + 1000.0 * cell.z))));
            random.next();
            return random.direction();
        }
        default:
            return glm::dvec3(0.0);
    }
}

glm::dmat3 anyTurn(Random& random) {
    const auto z = random.direction();
    const auto x = glm::normalize(glm::cross(z, random.direction() + glm::dvec3(0.01, 0.02, 0.03)));
    return {x, glm::cross(z, x), z};
}

Solid anySolid(Random& random, std::uint32_t number) {
    const auto shape =
        random.oneOf({Shape::box, Shape::box, Shape::ball, Shape::cylinder, Shape::cone, Shape::ring});
    Solid solid{shape, anyTurn(random), {}, {}, number * 8};
    const double away = random.between(5.0, 10.0);
    solid.middle = {random.between(-0.42, 0.42) * away, random.between(-0.25, 0.3) * away, -away};
    const double size = random.between(0.3, 1.0);
    solid.size = size * glm::dvec3(1.0, random.between(0.5, 1.3), random.between(0.4, 1.0));
    if (shape == Shape::ring) solid.size.y = size * random.between(0.25, 0.45);
    return solid;
}

/// The eye is at 0 and looks along -z.
std::vector<Solid> anySolids(Random& random, Relief relief) {
    std::vector<Solid> solids;
    const auto count = static_cast<std::uint32_t>(5 + random.below(6));
    for (std::uint32_t i = 0; i < count; ++i) solids.push_back(anySolid(random, i));
    const double lean = random.between(0.05, 0.2);
    const glm::dmat3 level(glm::dvec3(1, 0, 0), glm::dvec3(0, std::cos(lean), std::sin(lean)),
                           glm::dvec3(0, -std::sin(lean), std::cos(lean)));
    solids.push_back({Shape::box, level, {0, -2.6, -8.0}, {5.5, 0.3, 4.5}, count * 8});
    if (random.chance(0.5))
        solids.push_back({Shape::box, glm::dmat3(1.0), {0, 0, -13.5}, {20, 20, 0.2}, count * 8 + 8});
    if (relief == Relief::rough) {
        for (auto& solid : solids) {
            if (random.chance(0.5)) continue;
            solid.pattern = random.oneOf({Pattern::waves, Pattern::checks, Pattern::noise});
            solid.lean = random.between(0.2, 0.5);
        }
    }
    return solids;
}

struct Seen {
    double depth = HUGE_VAL, grey = 1.0, angle = 0.0;
    std::uint32_t part = Modalities::nothing;
};

Seen look(const std::vector<Solid>& solids, const glm::dvec3& direction) {
    const Light light;
    const auto towards = glm::normalize(light.direction);
    Seen seen;
    for (const auto& solid : solids) {
        const auto back = glm::transpose(solid.turn);
        const Ray ray{back * -solid.middle, back * direction};
        const auto hit = meet(ray, solid);
        if (!(hit.t > 0.0 && hit.t < seen.depth)) continue;
        const auto normal =
            solid.turn * glm::normalize(hit.normal + solid.lean * leanAt(solid.pattern, ray.at(hit.t)));
        seen.depth = hit.t;
        seen.grey = light.ambient + light.diffuse * std::max(0.0, glm::dot(normal, towards));
        seen.angle = std::hypot(normal.x, normal.y) > 1e-3 ? std::atan2(-normal.y, normal.x) : 0.0;
        seen.part = solid.firstPart + hit.face;
    }
    return seen;
}

Raster<std::uint8_t> boundaryOf(const Raster<std::uint32_t>& label) {
    Raster<std::uint8_t> made(label.width, label.height);
    const auto differ = [](std::uint32_t a, std::uint32_t b) {
        return a != b && a != UINT32_MAX && b != UINT32_MAX;
    };
    for (std::uint32_t row = 0; row < label.height; ++row) {
        for (std::uint32_t column = 0; column < label.width; ++column) {
            const auto own = label.at(column, row);
            made.at(column, row) = (column + 1 < label.width && differ(own, label.at(column + 1, row))) ||
                                   (row + 1 < label.height && differ(own, label.at(column, row + 1)));
        }
    }
    return made;
}

/// The share of `some` that lies near `others`.
double shareNear(const Raster<std::uint8_t>& some, const Raster<std::uint8_t>& others, double near) {
    const int reach = static_cast<int>(near), width = static_cast<int>(some.width),
              height = static_cast<int>(some.height);
    const auto found = [&](int column, int row) {
        for (int y = std::max(row - reach, 0); y <= std::min(row + reach, height - 1); ++y) {
            for (int x = std::max(column - reach, 0); x <= std::min(column + reach, width - 1); ++x) {
                if (std::hypot(x - column, y - row) <= near &&
                    others.at(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)))
                    return true;
            }
        }
        return false;
    };
    double count = 0.0, hits = 0.0;
    for (int row = 0; row < height; ++row) {
        for (int column = 0; column < width; ++column) {
            if (!some.at(static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(row))) continue;
            count += 1.0;
            hits += found(column, row) ? 1.0 : 0.0;
        }
    }
    return count > 0.0 ? hits / count : 0.0;
}

}  // namespace

PartScene partScene(Random& random, std::uint32_t width, std::uint32_t height, Relief relief) {
    const auto solids = anySolids(random, relief);
    const Raster<std::uint32_t> nothing(width, height, Modalities::nothing);
    PartScene scene{{Raster<float>(width, height, 1.0F), Raster<float>(width, height, HUGE_VALF),
                     Raster<float>(width, height), nothing, 10.0},
                    nothing};
    auto& made = scene.modalities;
    for (std::uint32_t row = 0; row < height; ++row) {
        for (std::uint32_t column = 0; column < width; ++column) {
            const auto i = made.grey.index(column, row);
            double grey = 0.0;
            for (const auto& place : places) {
                const double x = column + 0.5 + place.x - 0.5 * width, y = row + 0.5 + place.y - 0.5 * height;
                const auto seen = look(solids, {x / (focal * height), -y / (focal * height), -1.0});
                grey += seen.grey / static_cast<double>(places.size());
                if (!(static_cast<float>(seen.depth) < made.depth.values[i])) continue;
                made.depth.values[i] = static_cast<float>(seen.depth);
                made.angle.values[i] = static_cast<float>(seen.angle);
                scene.part.values[i] = seen.part;
                made.part.values[i] = 0;
            }
            made.grey.values[i] = static_cast<float>(grey);
        }
    }
    return scene;
}

BoundaryMeasure compareBoundaries(const Raster<std::uint32_t>& found, const Raster<std::uint32_t>& wanted,
                                  double near) {
    const auto a = boundaryOf(found), b = boundaryOf(wanted);
    return {shareNear(a, b, near), shareNear(b, a, near)};
}

}  // namespace mote::test
