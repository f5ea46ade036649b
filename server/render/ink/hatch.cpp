// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/hatch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>

#include "server/render/plan/in_turns.h"
#include "server/render/plan/long_list.h"
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

/// Orders runs by lines, and along each.
bool comesFirst(const Run& a, const Run& b) {
    return a.line != b.line ? a.line < b.line : a.begin < b.begin;
}

/// The parallel lines along which a region is hatched in one layer.
class LayerLines {
  public:
    LayerLines(const HatchAxes& axes, std::size_t layer, double spacing)
        : spacing_(spacing), origin_(axes.origin), offset_(layer < turns.size() ? 0.0 : 0.5) {
        const double angle = axes.direction + turns[layer % turns.size()];
        along_ = {std::cos(angle), std::sin(angle)};
        across_ = {-along_.y, along_.x};
        half_ = 0.5 * (std::abs(across_.x) + std::abs(across_.y));
    }

    /// Adds the runs through a pixel that wants such a share of all lines.
    void addRuns(const glm::dvec2& pixel, double share, std::vector<Run>& runs) const {
        const glm::dvec2 middle = pixel - origin_;
        const double place = glm::dot(across_, middle);
        const auto begin = static_cast<std::int64_t>(std::ceil((place - half_) / spacing_ - offset_));
        const auto end = static_cast<std::int64_t>(std::floor((place + half_) / spacing_ - offset_));
        for (auto line = begin; line <= end; ++line) {
            const auto turn = static_cast<std::size_t>(((line % 4) + 4) % 4);
            if (share * 4.0 > order[turn] + 0.5) addRun(line, middle, runs);
        }
    }
    HatchStroke stroke(const Run& run) const {
        const glm::dvec2 start = origin_ + distance(run.line) * across_;
        return {start + run.begin * along_, start + run.end * along_};
    }

  private:
    void addRun(std::int64_t line, const glm::dvec2& middle, std::vector<Run>& runs) const {
        const glm::dvec2 start = distance(line) * across_ - middle;
        double begin = -HUGE_VAL, end = HUGE_VAL;
        for (int axis = 0; axis < 2; ++axis) {
            if (along_[axis] == 0.0) continue;
            const double one = (-0.5 - start[axis]) / along_[axis],
                         other = (0.5 - start[axis]) / along_[axis];
            begin = std::max(begin, std::min(one, other));
            end = std::min(end, std::max(one, other));
        }
        if (begin < end) runs.push_back({line, begin, end});
    }
    double distance(std::int64_t line) const { return (static_cast<double>(line) + offset_) * spacing_; }

    double spacing_;
    glm::dvec2 origin_, along_{0.0}, across_{0.0};
    double offset_, half_ = 0.0;
};

using Pixels = std::span<const std::uint32_t>;

/// Hatches one region; used from any number of threads.
class RegionHatcher {
  public:
    RegionHatcher(const HatchRegions& regions, const HatchOptions& options)
        : regions_(regions), options_(options), added_(densities(options)) {}

    void hatch(Pixels pixels, const HatchAxes& axes, std::vector<HatchStroke>& strokes) const {
        eachLayer(mostOf(pixels), axes, [&](const LayerLines& lines, std::size_t layer, double before) {
            take(lines, runsOf(pixels, lines, layer, before), strokes);
        });
    }
    /// The same by steps of many threads, in turns.
    void hatchLarge(Pixels pixels, const HatchAxes& axes, std::vector<HatchStroke>& strokes) const {
        const std::size_t chunks = (pixels.size() + mostAtOnce - 1) / mostAtOnce;
        const auto chunk = [&](std::size_t i) {
            return pixels.subspan(i * mostAtOnce, std::min(mostAtOnce, pixels.size() - i * mostAtOnce));
        };
        std::vector<double> most(chunks);
        forInTurns(std::size_t{0}, chunks, [&](std::size_t i) { most[i] = mostOf(chunk(i)); });
        const double densest = *std::max_element(most.begin(), most.end());
        eachLayer(densest, axes, [&](const LayerLines& lines, std::size_t layer, double before) {
            std::vector<std::vector<Run>> runs(chunks);
            forInTurns(std::size_t{0}, chunks,
                       [&](std::size_t i) { runs[i] = runsOf(chunk(i), lines, layer, before); });
            takeAll(lines, runs, strokes);
        });
    }

    static constexpr std::size_t mostAtOnce = std::size_t{1} << 15;  ///< pixels

  private:
    template <class Take>
    void eachLayer(double most, const HatchAxes& axes, const Take& take) const {
        double before = 0.0;
        for (std::size_t layer = 0; layer < layers && before < most; ++layer) {
            take(LayerLines(axes, layer, options_.spacing), layer, before);
            before += added_[layer];
        }
    }
    double mostOf(Pixels pixels) const {
        double most = 0.0;
        for (const auto pixel : pixels)
            most = std::max(most, static_cast<double>(regions_.density.values[pixel]));
        return most;
    }
    /// The runs of a layer's lines through the pixels that want them, sorted.
    std::vector<Run> runsOf(Pixels pixels, const LayerLines& lines, std::size_t layer, double before) const {
        std::vector<Run> runs;
        const std::uint32_t width = regions_.label.width;
        for (const auto pixel : pixels) {
            const double share =
                (static_cast<double>(regions_.density.values[pixel]) - before) / added_[layer];
            const std::uint32_t column = pixel % width, row = pixel / width;
            if (share > 0.0) lines.addRuns({column + 0.5, row + 0.5}, share, runs);
        }
        std::sort(runs.begin(), runs.end(), comesFirst);
        return runs;
    }
    /// Runs that touch become strokes.
    void take(const LayerLines& lines, const std::vector<Run>& runs,
              std::vector<HatchStroke>& strokes) const {
        for (std::size_t i = 0; i < runs.size();) {
            Run run = runs[i++];
            for (; i < runs.size() && runs[i].line == run.line && runs[i].begin <= run.end + gap; ++i)
                run.end = std::max(run.end, runs[i].end);
            if (run.end - run.begin >= options_.shortest) strokes.push_back(lines.stroke(run));
        }
    }
    /// The same of several lists that are each sorted, some lines at a time.
    void takeAll(const LayerLines& lines, const std::vector<std::vector<Run>>& lists,
                 std::vector<HatchStroke>& strokes) const {
        std::int64_t first = std::numeric_limits<std::int64_t>::max(), end = -first;
        for (const auto& list : lists) {
            if (list.empty()) continue;
            first = std::min(first, list.front().line);
            end = std::max(end, list.back().line + 1);
        }
        if (first >= end) return;
        const auto groups = static_cast<std::int64_t>(lists.size());
        std::vector<std::vector<HatchStroke>> made(lists.size());
        forInTurns(std::int64_t{0}, groups, [&](std::int64_t group) {
            const auto from = first + (end - first) * group / groups,
                       to = first + (end - first) * (group + 1) / groups;
            std::vector<Run> runs;
            for (const auto& list : lists) {
                const auto at = [&](std::int64_t line) {
                    return std::partition_point(list.begin(), list.end(),
                                                [line](const Run& run) { return run.line < line; });
                };
                runs.insert(runs.end(), at(from), at(to));
            }
            std::sort(runs.begin(), runs.end(), comesFirst);
            take(lines, runs, made[static_cast<std::size_t>(group)]);
        });
        for (const auto& some : made) strokes.insert(strokes.end(), some.begin(), some.end());
    }

    const HatchRegions& regions_;
    const HatchOptions& options_;
    const std::array<double, layers> added_;
};

/// Pixels by their regions: those of region i from begins[i] to begins[i + 1].
struct RegionPixels {
    std::vector<std::size_t> begins;
    std::vector<std::uint32_t> pixels;
};

/// take(pixel, label) for each pixel that is of a region.
template <class Take>
void eachLabel(const HatchRegions& regions, const Take& take) {
    const auto& labels = regions.label.values;
    for (std::size_t pixel = 0; pixel < labels.size(); ++pixel) {
        if (pixel % longListStep<std::uint32_t> == 0) giveWay();
        if (labels[pixel] < regions.count) take(pixel, labels[pixel]);
    }
}

RegionPixels pixelsOf(const HatchRegions& regions) {
    RegionPixels made;
    made.begins.assign(std::size_t{regions.count} + 1, 0);
    eachLabel(regions, [&](std::size_t, std::uint32_t label) { ++made.begins[label + 1]; });
    std::partial_sum(made.begins.begin(), made.begins.end(), made.begins.begin());
    resizeInTurns(made.pixels, made.begins.back());
    auto next = made.begins;
    eachLabel(regions, [&](std::size_t pixel, std::uint32_t label) {
        made.pixels[next[label]++] = static_cast<std::uint32_t>(pixel);
    });
    return made;
}

}  // namespace

double mostHatched(const HatchOptions& options) {
    const auto added = densities(options);
    return std::accumulate(added.begin(), added.end(), 0.0);
}

std::vector<HatchAxes> hatchAxes(const HatchRegions& regions) {
    std::vector<DirectionSum> sums(regions.count);
    eachLabel(regions, [&](std::size_t pixel, std::uint32_t label) {
        const double angle = static_cast<double>(regions.angle.values[pixel]);
        if (angle != 0.0) sums[label].add(angle);
    });
    std::vector<HatchAxes> axes;
    axes.reserve(sums.size());
    for (const auto& sum : sums) axes.push_back({.direction = sum.mean()});
    return axes;
}

std::vector<HatchStroke> hatch(const HatchRegions& regions, const std::vector<HatchAxes>& axes,
                               const HatchOptions& options, const std::stop_token& stop) {
    const auto all = pixelsOf(regions);
    const auto pixelsOfRegion = [&](std::uint32_t region) {
        return Pixels(all.pixels).subspan(all.begins[region], all.begins[region + 1] - all.begins[region]);
    };
    const RegionHatcher hatcher(regions, options);
    std::vector<std::vector<HatchStroke>> made(regions.count);
    std::vector<std::uint32_t> small;
    for (std::uint32_t region = 0; region < regions.count && !isStopped(stop); ++region) {
        const auto pixels = pixelsOfRegion(region);
        if (pixels.size() > RegionHatcher::mostAtOnce)
            hatcher.hatchLarge(pixels, axes[region], made[region]);
        else
            small.push_back(region);
    }
    forInTurns(std::size_t{0}, small.size(), [&](std::size_t i) {
        const auto region = small[i];
        if (!isStopped(stop)) hatcher.hatch(pixelsOfRegion(region), axes[region], made[region]);
    });
    std::vector<HatchStroke> strokes;
    for (const auto& region : made) strokes.insert(strokes.end(), region.begin(), region.end());
    return strokes;
}

}  // namespace mote::render
