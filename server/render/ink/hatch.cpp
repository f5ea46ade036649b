// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/hatch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>

#include "server/render/plan/in_turns.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

constexpr double pi = std::numbers::pi;
// A layer's direction from the first one's; then the same again between their strokes.
constexpr std::array turns{0.0, 0.5 * pi, 0.25 * pi, 0.75 * pi};
constexpr std::size_t layers = 2 * turns.size();
// As a layer begins, first every fourth of its strokes is drawn, then those in the middle between them.
constexpr std::array order{0, 2, 1, 3};
constexpr double gap = 0.75;            // pixels between strokes of one line that are one
constexpr double leastAgreement = 0.1;  // of directions in a region that has one
constexpr double withoutDirection = 0.25 * pi;

/// What layers add to the density, one after another.
std::array<double, layers> densities(const HatchOptions& options) {
    const double once = std::min(options.width / options.spacing, 0.95);
    const double twice = std::min(2.0 * options.width / options.spacing, 0.98);
    std::array<double, layers> added{};
    for (std::size_t i = 0; i < layers; ++i)
        added[i] = i < turns.size() ? -std::log(1.0 - once) : std::log((1.0 - once) / (1.0 - twice));
    return added;
}

/// The mean of directions, which have no sign (of doubled angles: Mardia 1972).
class DirectionSum {
  public:
    void add(double angle) {
        sum_ += glm::dvec2(std::cos(2.0 * angle), std::sin(2.0 * angle));
        ++count_;
    }
    double mean() const {
        if (!(glm::length(sum_) > leastAgreement * count_)) return withoutDirection;
        return 0.5 * std::atan2(sum_.y, sum_.x);
    }

  private:
    glm::dvec2 sum_{0.0};
    double count_ = 0.0;
};

/// Part of a line of one direction.
struct Run {
    std::int64_t line;
    double begin, end;
};

/// One region after another; one thread's.
class RegionHatcher {
  public:
    RegionHatcher(const HatchRegions& regions, const HatchOptions& options)
        : regions_(regions), options_(options), added_(densities(options)) {}

    void hatch(const std::uint32_t* first, const std::uint32_t* last, const HatchAxes& axes,
               std::vector<HatchStroke>& strokes) {
        double most = 0.0;
        for (const auto* pixel = first; pixel != last; ++pixel)
            most = std::max(most, static_cast<double>(regions_.density.values[*pixel]));
        origin_ = axes.origin;
        double before = 0.0;
        for (std::size_t layer = 0; layer < layers && before < most; ++layer) {
            fill(first, last, axes.direction, layer, before);
            take(strokes);
            before += added_[layer];
        }
    }

  private:
    /// The runs of a layer's lines through the pixels that want them.
    void fill(const std::uint32_t* first, const std::uint32_t* last, double direction, std::size_t layer,
              double before) {
        const double angle = direction + turns[layer % turns.size()];
        along_ = {std::cos(angle), std::sin(angle)};
        across_ = {-along_.y, along_.x};
        offset_ = layer < turns.size() ? 0.0 : 0.5;
        const double half = 0.5 * (std::abs(across_.x) + std::abs(across_.y));
        runs_.clear();
        for (const auto* pixel = first; pixel != last; ++pixel) {
            const double share =
                (static_cast<double>(regions_.density.values[*pixel]) - before) / added_[layer];
            if (!(share > 0.0)) continue;
            const glm::dvec2 middle =
                glm::dvec2(*pixel % regions_.label.width + 0.5, *pixel / regions_.label.width + 0.5) -
                origin_;
            const double place = glm::dot(across_, middle);
            const auto begin =
                static_cast<std::int64_t>(std::ceil((place - half) / options_.spacing - offset_));
            const auto end =
                static_cast<std::int64_t>(std::floor((place + half) / options_.spacing - offset_));
            for (auto line = begin; line <= end; ++line) {
                const auto turn = static_cast<std::size_t>(((line % 4) + 4) % 4);
                if (share * 4.0 > order[turn] + 0.5) addRun(line, middle);
            }
        }
    }
    void addRun(std::int64_t line, const glm::dvec2& middle) {
        const glm::dvec2 start = distance(line) * across_ - middle;
        double begin = -HUGE_VAL, end = HUGE_VAL;
        for (int axis = 0; axis < 2; ++axis) {
            if (along_[axis] == 0.0) continue;
            const double one = (-0.5 - start[axis]) / along_[axis],
                         other = (0.5 - start[axis]) / along_[axis];
            begin = std::max(begin, std::min(one, other));
            end = std::min(end, std::max(one, other));
        }
        if (begin < end) runs_.push_back({line, begin, end});
    }
    double distance(std::int64_t line) const {
        return (static_cast<double>(line) + offset_) * options_.spacing;
    }

    /// Runs that touch become strokes.
    void take(std::vector<HatchStroke>& strokes) {
        std::sort(runs_.begin(), runs_.end(), [](const Run& a, const Run& b) {
            return a.line != b.line ? a.line < b.line : a.begin < b.begin;
        });
        for (std::size_t i = 0; i < runs_.size();) {
            Run run = runs_[i++];
            for (; i < runs_.size() && runs_[i].line == run.line && runs_[i].begin <= run.end + gap; ++i)
                run.end = std::max(run.end, runs_[i].end);
            if (run.end - run.begin < options_.shortest) continue;
            const glm::dvec2 start = origin_ + distance(run.line) * across_;
            strokes.push_back({start + run.begin * along_, start + run.end * along_});
        }
    }

    const HatchRegions& regions_;
    const HatchOptions& options_;
    const std::array<double, layers> added_;
    glm::dvec2 origin_{0.0}, along_{0.0}, across_{0.0};
    double offset_ = 0.0;
    std::vector<Run> runs_;
};

/// Pixels by their regions: those of region i from begins[i] to begins[i + 1].
struct RegionPixels {
    std::vector<std::size_t> begins;
    std::vector<std::uint32_t> pixels;
};

RegionPixels pixelsOf(const HatchRegions& regions) {
    RegionPixels made;
    made.begins.assign(std::size_t{regions.count} + 1, 0);
    const auto& labels = regions.label.values;
    for (const auto label : labels) {
        if (label < regions.count) ++made.begins[label + 1];
    }
    std::partial_sum(made.begins.begin(), made.begins.end(), made.begins.begin());
    made.pixels.resize(made.begins.back());
    auto next = made.begins;
    for (std::uint32_t pixel = 0; pixel < labels.size(); ++pixel) {
        if (labels[pixel] < regions.count) made.pixels[next[labels[pixel]]++] = pixel;
    }
    return made;
}

}  // namespace

double mostHatched(const HatchOptions& options) {
    const auto added = densities(options);
    return std::accumulate(added.begin(), added.end(), 0.0);
}

std::vector<HatchAxes> hatchAxes(const HatchRegions& regions) {
    std::vector<DirectionSum> sums(regions.count);
    for (std::size_t i = 0; i < regions.label.values.size(); ++i) {
        const double angle = static_cast<double>(regions.angle.values[i]);
        if (regions.label.values[i] < regions.count && angle != 0.0) sums[regions.label.values[i]].add(angle);
    }
    std::vector<HatchAxes> axes;
    for (const auto& sum : sums) axes.push_back({.direction = sum.mean()});
    return axes;
}

std::vector<HatchStroke> hatch(const HatchRegions& regions, const std::vector<HatchAxes>& axes,
                               const HatchOptions& options, const std::stop_token& stop) {
    const auto all = pixelsOf(regions);
    std::vector<std::vector<HatchStroke>> made(regions.count);
    forInTurns(std::uint32_t{0}, regions.count, [&](std::uint32_t region) {
        if (isStopped(stop)) return;
        RegionHatcher hatcher(regions, options);
        hatcher.hatch(all.pixels.data() + all.begins[region], all.pixels.data() + all.begins[region + 1],
                      axes[region], made[region]);
    });
    std::vector<HatchStroke> strokes;
    for (const auto& region : made) strokes.insert(strokes.end(), region.begin(), region.end());
    return strokes;
}

}  // namespace mote::render
