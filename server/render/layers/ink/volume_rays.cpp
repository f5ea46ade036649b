// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/volume_rays.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>
#include <utility>

#include "server/render/plan/seen_fields.h"

namespace mote::render {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double exactStep = 0.75, quickStep = 1.5;  // cells
constexpr double mostSteps = 1 << 16;                // of a ray
constexpr double leastLeft = 2e-3;                   // of a ray's light: what lies behind is not seen
constexpr double leastLost = 1e-5;                   // of a ray's light in a step: less is nothing
constexpr double finest = 0.08;                      // of a ray's light, that a part of a step absorbs
constexpr double mostParts = 8.0;

constexpr double shadedTogether = 0.04;  // of a ray's light, and so many cells of a way, have one normal
constexpr double shadedWithin = 2.0;

/// As shadesOf() has it (layers/hybrid/shades.h).
double frontShare(double towardsEye) {
    const double x = std::clamp(2.0 * towardsEye + 0.5, 0.0, 1.0);
    return x * x * (3.0 - 2.0 * x);
}

double shine(double cosine) {
    double power = std::max(0.0, cosine);
    for (int i = 0; i < 5; ++i) power *= power;
    return power;
}

/// What a thickness absorbs: 1 - exp(-thickness). Thin ones are by far the most; a series is exact to 1e-9.
double absorbedBy(double thickness) {
    constexpr double least = 0.01;
    if (thickness > least) return -std::expm1(-thickness);
    return thickness * (1.0 - thickness / 2.0 * (1.0 - thickness / 3.0));
}

/// How far a place is from where it leaves [low, high] on a way, in steps.
double leaves(double at, double step, double low, double high) {
    if (step > 0.0) return (high - at) / step;
    return step < 0.0 ? (low - at) / step : infinity;
}

}  // namespace

/// A ray in steps through the field's box.
struct VolumeRays::Way {
    glm::dvec3 begin{0.0}, step{0.0};   // cells
    double depth = 0.0, perStep = 0.0;  // world units
    double steps = 0.0;                 // not a whole number
    double length = 0.0;                // of a step, layer units

    glm::dvec3 at(double i) const { return begin + i * step; }
    double depthAt(double i) const { return depth + i * perStep; }
};

/// A part of a way, in its steps.
struct VolumeRays::Stretch {
    double begin, end;
};

/// What has been gathered of a ray.
struct VolumeRays::Sight {
    double left = 1.0;
    double light = 0.0;
    glm::dvec3 normal{0.0};
    Marks& marks;
    // What is yet to be shaded: how much of the ray, from which step on, and the sum of steps by it.
    double absorbed = 0.0, from = 0.0, places = 0.0;

    void absorb(double step, double more) {
        if (absorbed == 0.0) from = step;
        absorbed += more;
        places += more * step;
        left -= more;
    }
};

VolumeRays::VolumeRays(const InkVolume& volume, const glm::dmat4& transform, const Light& light,
                       const FramePlan& plan)
    : field_(*volume.field),
      samples_(field_),
      table_(volume.transfer),
      extinction_(field_, table_),
      blocks_(gridRanges({.grid = volume.field}), table_),
      light_(light),
      perspective_(plan.camera.perspective()),
      nearest_(nearLimit(plan.camera)),
      size_(plan.width, plan.height),
      pixels_(plan.height / (2.0 * plan.camera.halfHeight())),
      stepLength_(plan.exact ? exactStep : quickStep) {
    const glm::dmat4 cellsToLayer = glm::scale(field_.boxToLayer, 1.0 / samples_.cells());
    cellsToEye_ = plan.camera.worldToEye() * transform * cellsToLayer;
    eyeToCells_ = glm::inverse(cellsToEye_);
    cellsToLayer_ = glm::dmat3(cellsToLayer);
    slopeToNormal_ = -glm::transpose(glm::dmat3(eyeToCells_));
    towards_ = glm::normalize(light.fixed ? glm::dmat3(plan.camera.worldToEye()) * light.direction
                                          : light.direction);
    const glm::dvec3 sum = towards_ + glm::dvec3(0.0, 0.0, 1.0);
    half_ = glm::length(sum) > 1e-9 ? glm::normalize(sum) : glm::dvec3(0.0);
}

Bounds VolumeRays::visible() const {
    const glm::uvec3 count = blocks_.count();
    const double edge = 1U << blocks_.edgeBits();
    Bounds cells{glm::dvec3(infinity), glm::dvec3(-infinity)};
    std::size_t i = 0;
    for (std::uint32_t z = 0; z < count.z; ++z) {
        for (std::uint32_t y = 0; y < count.y; ++y) {
            for (std::uint32_t x = 0; x < count.x; ++x, ++i) {
                if (blocks_.steps()[i] < VisibleBlocks::visible) continue;
                const glm::dvec3 corner = edge * glm::dvec3(x, y, z);
                cells.min = glm::min(cells.min, corner);
                cells.max = glm::max(cells.max, corner + edge);
            }
        }
    }
    if (!any()) return field_.bounds();
    // A block also has what lies half a cell before its first sample, and the last of a side all that is
    // left.
    cells.min = glm::max(cells.min, glm::dvec3(0.0));
    cells.max = glm::min(cells.max + 0.5, samples_.cells());
    return cells.transformed(glm::scale(field_.boxToLayer, 1.0 / samples_.cells()));
}

/// Through the box, in steps as long on every ray.
VolumeRays::Way VolumeRays::wayThrough(double x, double y) const {
    const glm::dvec2 window = glm::dvec2(x - 0.5 * size_.x, 0.5 * size_.y - y) / pixels_;
    const glm::dvec3 origin = perspective_ ? glm::dvec3(0.0) : glm::dvec3(window, 0.0);
    const glm::dvec3 perDepth = perspective_ ? glm::dvec3(window, -1.0) : glm::dvec3(0.0, 0.0, -1.0);
    const glm::dvec3 from(eyeToCells_ * glm::dvec4(origin, 1.0)), way = glm::dmat3(eyeToCells_) * perDepth;
    double enter = nearest_, leave = infinity;
    for (int axis = 0; axis < 3; ++axis) {
        const double end = samples_.cells()[axis];
        if (way[axis] == 0.0) {
            if (from[axis] < 0.0 || from[axis] > end) return {};
            continue;
        }
        const double one = -from[axis] / way[axis], other = (end - from[axis]) / way[axis];
        enter = std::max(enter, std::min(one, other));
        leave = std::min(leave, std::max(one, other));
    }
    const double inside = leave - enter;
    if (!(inside > 0.0) || !std::isfinite(inside)) return {};
    const double stepsADepth = std::min(glm::length(way) / stepLength_, mostSteps / inside);
    Way made{.begin = from + enter * way,
             .step = way / stepsADepth,
             .depth = enter,
             .perStep = 1.0 / stepsADepth,
             .steps = inside * stepsADepth};
    made.length = glm::length(cellsToLayer_ * made.step);
    // If a transform has no inverse there is no way.
    return std::isfinite(glm::dot(made.begin + made.step, glm::dvec3(1.0))) ? made : Way{};
}

std::uint8_t VolumeRays::blockAt(const glm::vec3& place) const {
    const glm::vec3 sample = glm::clamp(place - 0.5F, glm::vec3(0.0F), glm::vec3(samples_.cells() - 1.0));
    const glm::uvec3 at = glm::uvec3(sample) >> glm::uvec3(blocks_.edgeBits());
    const glm::uvec3& count = blocks_.count();
    return blocks_.steps()[(std::size_t{at.z} * count.y + at.y) * count.x + at.x];
}

bool VolumeRays::visibleAt(const glm::vec3& place) const {
    return blockAt(place) >= VisibleBlocks::visible;
}

double VolumeRays::skip(const Way& way, double step) const {
    const glm::dvec3 sample = way.at(step) - 0.5;
    const double blocks = std::max<int>(blockAt(glm::vec3(way.at(step))) & VisibleBlocks::farthest, 1);
    const double edge = 1U << blocks_.edgeBits();
    double most = infinity;
    for (int axis = 0; axis < 3; ++axis) {
        const double last = samples_.cells()[axis] - 1.0;
        const double block = std::floor(std::clamp(sample[axis], 0.0, last) / edge);
        most = std::min(most, leaves(sample[axis], way.step[axis], (block - blocks + 1.0) * edge,
                                     (block + blocks) * edge));
    }
    return std::max(step + 1.0, std::floor(step + most));
}

/// By parts in which little is absorbed, so that depths within a step are told.
void VolumeRays::meet(const Way& way, const Stretch& stretch, double from, double to, Sight& sight) const {
    const double length = stretch.end - stretch.begin;
    const double thickness = extinction_.mean(from, to) * way.length * length;
    if (!(sight.left * thickness > leastLost)) return;
    const double parts = std::clamp(std::ceil(thickness / finest), 1.0, mostParts);
    const double start = way.depthAt(stretch.begin);
    if (sight.marks.empty() || sight.marks.back().depth < start)
        sight.marks.push_back({start, 1.0 - sight.left});
    for (double part = 0.0; part < parts; ++part) {
        const double begin = part / parts, end = (part + 1.0) / parts;
        const double mean = parts == 1.0
                                ? thickness
                                : way.length * length *
                                      extinction_.mean(std::lerp(from, to, begin), std::lerp(from, to, end));
        sight.absorb(stretch.begin + 0.5 * (begin + end) * length, sight.left * absorbedBy(mean / parts));
        sight.marks.push_back({way.depthAt(stretch.begin + end * length), 1.0 - sight.left});
    }
    const bool far = (stretch.end - sight.from) * stepLength_ >= shadedWithin;
    if (far || sight.absorbed > shadedTogether) shade(way, sight);
}

/// As docs/PICTURE.md, "Light", has it, of the normal that the field has there.
void VolumeRays::shade(const Way& way, Sight& sight) const {
    const double absorbed = std::exchange(sight.absorbed, 0.0), places = std::exchange(sight.places, 0.0);
    if (!(absorbed > 0.0)) return;
    const glm::dvec3 across =
        slopeToNormal_ * glm::dvec3(samples_.slope(glm::vec3(way.at(places / absorbed))));
    const double length = glm::length(across);
    if (!(length > 0.0)) {
        sight.light += absorbed * std::min(1.0, light_.ambient + light_.diffuse);
        return;
    }
    const glm::dvec3 normal = across / length;
    const double front = frontShare(normal.z), lit = glm::dot(normal, towards_),
                 shines = glm::dot(normal, half_);
    const double diffuse = front * std::max(0.0, lit) + (1.0 - front) * std::max(0.0, -lit);
    const double specular = front * shine(shines) + (1.0 - front) * shine(-shines);
    sight.light += absorbed * std::min(1.0, std::min(1.0, light_.ambient + light_.diffuse * diffuse) +
                                                light_.specular * specular);
    sight.normal += absorbed * (normal.z < 0.0 ? -across : across);
}

VolumeSeenOn VolumeRays::look(double x, double y, Marks& marks) const {
    const Way way = wayThrough(x, y);
    marks.clear();
    Sight sight{.marks = marks};
    double before = 0.0;
    bool known = false;
    for (double step = 0.0; step < way.steps && sight.left > leastLeft;) {
        const double end = std::min(step + 1.0, way.steps);
        if (!visibleAt(glm::vec3(way.at(step))) && !visibleAt(glm::vec3(way.at(end)))) {
            shade(way, sight);
            step = skip(way, step);
            known = false;
            continue;
        }
        if (!known) before = extinction_.at(samples_.code(glm::vec3(way.at(step))));
        const double after = extinction_.at(samples_.code(glm::vec3(way.at(end))));
        meet(way, {step, end}, before, after, sight);
        before = after;
        known = true;
        step = end;
    }
    shade(way, sight);
    VolumeSeenOn seen{.opacity = 1.0 - sight.left, .light = sight.light, .normal = sight.normal};
    if (marks.empty()) return seen;
    const double middle = 0.5 * marks.back().absorbed;
    std::size_t i = 1;
    while (i + 1 < marks.size() && marks[i].absorbed < middle) ++i;
    const Mark &from = marks[i - 1], &to = marks[i];
    const double share =
        to.absorbed > from.absorbed ? (middle - from.absorbed) / (to.absorbed - from.absorbed) : 0.0;
    seen.depth = std::lerp(from.depth, to.depth, std::clamp(share, 0.0, 1.0));
    return seen;
}

}  // namespace mote::render
