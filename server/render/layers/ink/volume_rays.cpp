// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/volume_rays.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
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
constexpr int mostParts = 8;
constexpr double stepsTogether = 15.0;  // at least, unless what can be seen ends

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

/// What a thickness absorbs: 1 - exp(-thickness), by a series that is exact to 1e-11; of thick ones that of a
/// half, again and again.
double absorbedBy(double thickness) {
    constexpr double most = 0.25, all = 40.0;
    if (thickness > all) return 1.0;
    int halved = 0;
    for (; thickness > most; ++halved) thickness *= 0.5;
    const double t = thickness, t2 = t * t, t4 = t2 * t2;
    const double low = 1.0 - t / 2.0 + t2 * (1.0 / 6.0 - t / 24.0);
    const double high = 1.0 / 120.0 - t / 720.0 + t2 * (1.0 / 5040.0 - t / 40320.0);
    double absorbed = t * (low + t4 * high);
    for (; halved > 0; --halved) absorbed *= 2.0 - absorbed;
    return absorbed;
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
    double stepAt(double at) const { return (at - depth) / perStep; }
};

/// The blocks on a way, one after the other (Amanatides and Woo 1987, A fast voxel traversal algorithm for
/// ray tracing).
class VolumeRays::BlockWalk {
  public:
    /// From a step to another.
    BlockWalk(const VolumeRays& rays, const Way& way, double from, double to) : steps_(to), end_(from) {
        const double edge = 1U << rays.blocks_.edgeBits();
        const glm::ivec3 count(rays.blocks_.count());
        const glm::ivec3 strides(1, count.x, count.x * count.y);
        for (int axis = 0; axis < 3; ++axis) {
            // From a block's first sample to the next one's.
            const double sample = way.begin[axis] - 0.5, step = way.step[axis];
            const int at =
                std::clamp(static_cast<int>(std::floor((sample + from * step) / edge)), 0, count[axis] - 1);
            block_ += std::ptrdiff_t{at} * strides[axis];
            left_[axis] = step > 0.0 ? count[axis] - 1 - at : at;
            stride_[axis] = step > 0.0 ? strides[axis] : -strides[axis];
            if (step == 0.0 || left_[axis] == 0) continue;
            next_[axis] = ((step > 0.0 ? at + 1 : at) * edge - sample) / step;
            across_[axis] = edge / std::abs(step);
        }
        findEnd();
    }

    std::size_t block() const { return static_cast<std::size_t>(block_); }
    double begin() const { return begin_; }  ///< steps
    double end() const { return end_; }
    bool last() const { return end_ >= steps_; }
    void goOn() {
        block_ += stride_[axis_];
        next_[axis_] = --left_[axis_] > 0 ? next_[axis_] + across_[axis_] : infinity;
        findEnd();
    }

  private:
    void findEnd() {
        begin_ = end_;
        axis_ = next_.x < next_.y ? (next_.x < next_.z ? 0 : 2) : (next_.y < next_.z ? 1 : 2);
        end_ = std::max(begin_, std::min(next_[axis_], steps_));
    }

    double steps_;
    glm::dvec3 next_{infinity}, across_{infinity};  // steps to the next block along each axis, and between
    glm::ivec3 left_{0}, stride_{0};                // blocks on the way
    std::ptrdiff_t block_ = 0;
    int axis_ = 0;  // of the next one
    double begin_ = 0.0, end_ = 0.0;
};

/// A part of a way, in its steps.
struct VolumeRays::Stretch {
    double begin, end;
};

/// Steps that wait to be followed.
struct VolumeRays::Run {
    double begin = 0.0, end = 0.0;
};

/// Some places of a way.
struct VolumeRays::Samples {
    static constexpr std::size_t together = SamplePlaces::together;
    std::array<double, together> steps, places;  // of the way, in the table
};

/// What has been gathered of a ray.
struct VolumeRays::Sight {
    double left = 1.0;
    std::vector<Mark>& marks;
    std::vector<Part>& parts;
    // Of the next part: how much of the ray, from which step on, and the sum of steps by it.
    double absorbed = 0.0, from = 0.0, places = 0.0;
    double at = -1.0, place = 0.0;  // the step that it was followed to, and the field's place in the table

    void absorb(double step, double more) {
        if (absorbed == 0.0) from = step;
        absorbed += more;
        places += more * step;
        left -= more;
    }
    void endPart() {
        if (absorbed > 0.0) parts.push_back({places / absorbed, absorbed});
        absorbed = places = 0.0;
    }
};

VolumeRays::VolumeRays(const InkVolume& volume, const glm::dmat4& transform, const Light& light,
                       const FramePlan& plan)
    : VolumeRays(volume, gridRanges({.grid = volume.field}), transform, light, plan) {}

VolumeRays::VolumeRays(const InkVolume& volume, const BlockRanges& ranges, const glm::dmat4& transform,
                       const Light& light, const FramePlan& plan)
    : field_(*volume.field),
      samples_(field_),
      table_(volume.transfer),
      extinction_(field_, table_),
      blocks_(ranges, table_),
      cellsToLayer_(glm::scale(field_.boxToLayer, 1.0 / samples_.cells())),
      light_(light),
      perspective_(plan.camera.perspective()),
      clips_(inSpace(volume.clips, glm::scale(field_.boxToLayer, 1.0 / samples_.cells()))),
      nearest_(nearLimit(plan.camera)),
      size_(plan.width, plan.height),
      pixels_(plan.height / (2.0 * plan.camera.halfHeight())),
      stepLength_(plan.exact ? exactStep : quickStep) {
    for (const auto& range : ranges.ranges())
        most_.push_back(static_cast<float>(extinction_.most(double{range.low}, double{range.high})));
    leastExtinction_ = static_cast<float>(leastLost / longestStep());
    const glm::dmat4 cellsToLayer = glm::scale(field_.boxToLayer, 1.0 / samples_.cells());
    cellsToEye_ = plan.camera.worldToEye() * transform * cellsToLayer;
    eyeToCells_ = glm::inverse(cellsToEye_);
    slopeToNormal_ = -glm::transpose(glm::dmat3(eyeToCells_));
    towards_ = glm::normalize(light.fixed ? glm::dmat3(plan.camera.worldToEye()) * light.direction
                                          : light.direction);
    const glm::dvec3 sum = towards_ + glm::dvec3(0.0, 0.0, 1.0);
    half_ = glm::length(sum) > 1e-9 ? glm::normalize(sum) : glm::dvec3(0.0);
}

Bounds VolumeRays::cellsOf(const glm::uvec3& block) const {
    const double edge = 1U << blocks_.edgeBits();
    const glm::dvec3 corner = edge * glm::dvec3(block);
    return {corner, glm::min(corner + edge + 0.5, samples_.cells())};
}

Bounds VolumeRays::visible() const {
    const glm::uvec3 count = blocks_.count();
    Bounds cells{glm::dvec3(infinity), glm::dvec3(-infinity)};
    std::size_t i = 0;
    for (std::uint32_t z = 0; z < count.z; ++z) {
        for (std::uint32_t y = 0; y < count.y; ++y) {
            for (std::uint32_t x = 0; x < count.x; ++x, ++i) {
                if (blocks_.steps()[i] < VisibleBlocks::visible) continue;
                const Bounds own = cellsOf({x, y, z});
                cells.min = glm::min(cells.min, own.min);
                cells.max = glm::max(cells.max, own.max);
            }
        }
    }
    if (!any()) return field_.bounds();
    return cells.transformed(glm::scale(field_.boxToLayer, 1.0 / samples_.cells()));
}

void VolumeRays::findSpans() {
    const DepthSpans nothing({size_, pixels_, perspective_, nearest_});
    const glm::uvec3 count = blocks_.count();
    tbb::enumerable_thread_specific<DepthSpans> found(nothing);
    tbb::parallel_for(0U, count.y * count.z, [&](std::uint32_t row) {
        auto& spans = found.local();
        for (std::uint32_t x = 0; x < count.x; ++x) {
            if (!isCounted(std::size_t{row} * count.x + x)) continue;
            const Bounds cells = cellsOf({x, row % count.y, row / count.y});
            std::array<glm::dvec3, 8> corners;
            for (int i = 0; i < 8; ++i) {
                const glm::dvec3 corner = glm::mix(cells.min, cells.max, glm::bvec3(i & 1, i & 2, i & 4));
                corners[static_cast<std::size_t>(i)] = cellsToEye_ * glm::dvec4(corner, 1.0);
            }
            spans.add(corners);
        }
    });
    spans_ = nothing;
    for (const auto& spans : found) spans_->add(spans);
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
    clipWay(clips_, from, way, enter, leave);
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

double VolumeRays::longestStep() const {
    double squares = 0.0;
    for (int axis = 0; axis < 3; ++axis) squares += glm::dot(cellsToLayer_[axis], cellsToLayer_[axis]);
    return stepLength_ * std::sqrt(squares);
}

bool VolumeRays::mayAbsorb(const Way& way, double thickness, BlockWalk& walk) const {
    const double enough = thickness / way.length;
    double sum = 0.0;
    bool counted = false;
    for (BlockWalk ahead = walk;; ahead.goOn()) {
        const float most = most_[ahead.block()];
        if (!counted && isCounted(ahead.block())) {
            counted = true;
            walk = ahead;
        }
        // A step has the values at both its ends, and so may have all the extinction of either's block.
        sum += double{most} * (ahead.end() - ahead.begin() + 1.0);
        if (sum > enough) break;
        if (ahead.last()) return false;
    }
    return true;
}

/// By parts in which little is absorbed, so that depths within a step are told.
void VolumeRays::meet(const Way& way, const Stretch& stretch, double from, double to, Sight& sight) const {
    const double length = stretch.end - stretch.begin;
    const double thickness = extinction_.mean(from, to) * way.length * length;
    if (!(sight.left * thickness > leastLost)) return;
    const double start = way.depthAt(stretch.begin);
    if (sight.marks.empty() || sight.marks.back().depth < start)
        sight.marks.push_back({start, 1.0 - sight.left});
    const double lost = sight.left * std::min(thickness, 1.0);  // at most
    const int parts = std::clamp(static_cast<int>(std::ceil(lost / finest)), 1, mostParts);
    const ExtinctionTable::Spread spread(extinction_, from, to);
    double before = 0.0;  // of the thickness
    for (int part = 0; part < parts;) {
        // All that is not seen is one.
        const int next = sight.left > leastLeft ? part + 1 : parts;
        const double begin = static_cast<double>(part) / parts, end = static_cast<double>(next) / parts;
        const double until = next == parts ? thickness : thickness * spread(end);
        sight.absorb(stretch.begin + 0.5 * (begin + end) * length, sight.left * absorbedBy(until - before));
        sight.marks.push_back({way.depthAt(stretch.begin + end * length), 1.0 - sight.left});
        part = next;
        before = until;
    }
    const bool far = (stretch.end - sight.from) * stepLength_ >= shadedWithin;
    if (far || sight.absorbed > shadedTogether) sight.endPart();
}

/// As docs/PICTURE.md, "Light", has it, of the normal that the field has there.
void VolumeRays::shade(const glm::vec3& slope, double absorbed, VolumeSeenOn& seen) const {
    const glm::dvec3 across = slopeToNormal_ * glm::dvec3(slope);
    const double length = glm::length(across);
    if (!(length > 0.0)) {
        seen.light += absorbed * std::min(1.0, light_.ambient + light_.diffuse);
        return;
    }
    const glm::dvec3 normal = across / length;
    const double front = frontShare(normal.z), lit = glm::dot(normal, towards_),
                 shines = glm::dot(normal, half_);
    const double diffuse = front * std::max(0.0, lit) + (1.0 - front) * std::max(0.0, -lit);
    const double specular = front * shine(shines) + (1.0 - front) * shine(-shines);
    seen.light += absorbed * std::min(1.0, std::min(1.0, light_.ambient + light_.diffuse * diffuse) +
                                               light_.specular * specular);
    seen.normal += absorbed * (normal.z < 0.0 ? -across : across);
}

void VolumeRays::shade(const Way& way, const std::vector<Part>& parts, VolumeSeenOn& seen) const {
    constexpr std::size_t together = SamplePlaces::together;
    std::array<glm::vec3, together> places, slopes;
    for (std::size_t begin = 0; begin < parts.size(); begin += together) {
        const std::size_t count = std::min(together, parts.size() - begin);
        for (std::size_t i = 0; i < count; ++i) places[i] = way.at(parts[begin + i].step);
        samples_.slopes({places.data(), count}, {slopes.data(), count});
        for (std::size_t i = 0; i < count; ++i) shade(slopes[i], parts[begin + i].absorbed, seen);
    }
}

/// Repeats the last step behind it. Each loop has one kind of number: the compiler makes vectors of it.
void VolumeRays::sample(const Way& way, double first, double last, Samples& found) const {
    constexpr std::size_t count = Samples::together;
    for (std::size_t i = 0; i < count; ++i)
        found.steps[i] = std::min(first + static_cast<double>(static_cast<int>(i)), last);
    SamplePlaces places;
    const auto fill = [&](int axis, auto& list) {
        const double begin = way.begin[axis], step = way.step[axis];
        for (std::size_t i = 0; i < count; ++i) list[i] = static_cast<float>(begin + found.steps[i] * step);
    };
    fill(0, places.x);
    fill(1, places.y);
    fill(2, places.z);
    places.size = count;
    SampleCodes codes;
    samples_.codes(places, codes);
    for (std::size_t i = 0; i < count; ++i) found.places[i] = extinction_.at(codes[i]);
}

void VolumeRays::march(const Way& way, Run& run, Sight& sight) const {
    double step = std::exchange(run.begin, run.end);
    if (step == run.end) return;
    bool known = step == sight.at;
    Samples found;
    while (step < run.end && sight.left > leastLeft) {
        // Those at the ends of steps, and before all if that is not known.
        sample(way, known ? step + 1.0 : step, run.end, found);
        std::size_t i = 0;
        if (!std::exchange(known, true)) sight.place = found.places[i++];
        for (; i < Samples::together && step < run.end && sight.left > leastLeft; ++i) {
            const double before = std::exchange(sight.place, found.places[i]);
            if (!extinction_.isNothing(before, sight.place))
                meet(way, {step, found.steps[i]}, before, sight.place, sight);
            step = found.steps[i];
        }
    }
    sight.at = step;
}

VolumeSeenOn VolumeRays::look(double x, double y, double least, Scratch& scratch) const {
    auto& [marks, parts] = scratch;
    marks.clear();
    parts.clear();
    const DepthSpan span = spans_ ? spans_->at(x, y) : DepthSpan{-infinity, infinity};
    if (!(span.near <= span.far)) return {};
    const Way way = wayThrough(x, y);
    // By a step more, since one counts whose end is met.
    const double from = std::max(0.0, std::floor(way.stepAt(span.near)) - 1.0),
                 to = std::min(way.steps, std::ceil(way.stepAt(span.far)) + 1.0);
    if (!(to > from)) return {};
    BlockWalk walk(*this, way, from, to);
    if (!mayAbsorb(way, -std::log1p(-least), walk)) return {};
    Sight sight{.marks = marks, .parts = parts};
    Run run;
    for (;; walk.goOn()) {
        if (isCounted(walk.block())) {
            // Those steps of which an end lies in the block.
            const double first = std::max(run.end, std::ceil(walk.begin()) - 1.0);
            if (first > run.end) {
                march(way, run, sight);
                sight.endPart();
                run.begin = first;
            }
            run.end = std::max(first, std::min(std::ceil(walk.end()), way.steps));
            if (run.end - run.begin >= stepsTogether) march(way, run, sight);
        }
        if (walk.last() || !(sight.left > leastLeft)) break;
    }
    march(way, run, sight);
    sight.endPart();
    VolumeSeenOn seen{.opacity = 1.0 - sight.left};
    if (!(seen.opacity >= least)) return {};
    shade(way, parts, seen);
    if (marks.empty()) return seen;
    seen.depth = depthWhere(scratch, 0.5 * marks.back().absorbed);
    return seen;
}

double VolumeRays::depthWhere(const Scratch& scratch, double absorbed) {
    const auto& marks = scratch.marks;
    if (marks.empty()) return infinity;
    std::size_t i = 1;
    while (i + 1 < marks.size() && marks[i].absorbed < absorbed) ++i;
    if (i == marks.size()) return marks.front().depth;
    const Mark &from = marks[i - 1], &to = marks[i];
    const double share =
        to.absorbed > from.absorbed ? (absorbed - from.absorbed) / (to.absorbed - from.absorbed) : 0.0;
    return std::lerp(from.depth, to.depth, std::clamp(share, 0.0, 1.0));
}

double VolumeRays::absorbedBefore(const Scratch& scratch, double depth) {
    const auto& marks = scratch.marks;
    const auto to = std::upper_bound(marks.begin(), marks.end(), depth,
                                     [](double place, const Mark& mark) { return place < mark.depth; });
    if (to == marks.begin()) return 0.0;
    if (to == marks.end()) return marks.back().absorbed;
    const Mark& from = *(to - 1);
    return std::lerp(from.absorbed, to->absorbed, (depth - from.depth) / (to->depth - from.depth));
}

glm::dvec3 VolumeRays::boxPlace(double x, double y, double depth) const {
    const glm::dvec2 window = glm::dvec2(x - 0.5 * size_.x, 0.5 * size_.y - y) / pixels_;
    const glm::dvec3 inEye(perspective_ ? depth * window : window, -depth);
    return glm::dvec3(eyeToCells_ * glm::dvec4(inEye, 1.0)) / samples_.cells();
}

double VolumeRays::codeAt(double x, double y, double depth) const {
    return static_cast<double>(samples_.code(glm::vec3(boxPlace(x, y, depth) * samples_.cells())));
}

}  // namespace mote::render
