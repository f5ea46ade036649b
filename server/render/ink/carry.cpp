// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/carry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>

#include "server/render/ink/segment_regions.h"
#include "server/render/ink/segments_growing.h"
#include "server/render/ink/tone_grid.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

constexpr double square = 4.0;       // pixels
constexpr double reach = 1.5;        // pixels between a line and itself
constexpr double leastCosine = 0.8;  // cosine of what it turns by

constexpr std::uint32_t nowhere = UINT32_MAX;
constexpr double alikeDepth = 0.01;     // of the extent: what is one place in two pictures differs by less
constexpr double alikeLine = 0.004;     // likewise of lines, which lie in crowds
constexpr double outgrown = 1.5;        // times what differs within a region: no longer of it
constexpr double mostTurn = 0.005;      // radians that strokes turn by in a picture
constexpr double otherWay = 0.5;        // radians: strokes are drawn anew rather than turned
constexpr double mostShare = 0.5;       // of a region, that it has from the one it was
constexpr float kept = 0.8F;            // of the density before
constexpr std::array around{0, -1, 1};  // pixels beside that in which a place was

/// Calls take(pixel) for those of a picture at a place and around it, until it says true.
template <class T, class Take>
void eachAround(const Raster<T>& picture, const glm::dvec2& at, const Take& take) {
    if (!(at.x >= 0.0 && at.y >= 0.0 && at.x < picture.width && at.y < picture.height)) return;
    for (const int down : around) {
        for (const int across : around) {
            const auto column = static_cast<std::int64_t>(at.x) + across;
            const auto row = static_cast<std::int64_t>(at.y) + down;
            if (column < 0 || row < 0 || column >= picture.width || row >= picture.height) continue;
            if (take(picture.index(static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(row))))
                return;
        }
    }
}

Raster<std::uint32_t> seenBefore(const Modalities& now, const PictureMotion& motion,
                                 const InkMemory& before) {
    const auto& depth = now.depth;
    Raster<std::uint32_t> from(depth.width, depth.height, nowhere);
    const double most = alikeDepth * before.extent;
    forInTurns(std::uint32_t{0}, depth.height, [&](std::uint32_t row) {
        for (std::uint32_t column = 0; column < depth.width; ++column) {
            const auto here = static_cast<double>(depth.at(column, row));
            if (!std::isfinite(here)) continue;
            const auto was = motion({{column + 0.5, row + 0.5}, here});
            eachAround(before.depth, was.at, [&](std::size_t pixel) {
                if (!(std::abs(static_cast<double>(before.depth.values[pixel]) - was.depth) <= most))
                    return false;
                from.at(column, row) = static_cast<std::uint32_t>(pixel);
                return true;
            });
        }
    });
    return from;
}

/// What is like each region that was carried, of what is seen of it now.
struct CarriedMeans {
    std::vector<double> pixels, grey;
    std::vector<glm::dvec2> direction;  // twice its angle

    CarriedMeans(const Modalities& now, const Raster<std::uint32_t>& labels, std::uint32_t count)
        : pixels(count), grey(count), direction(count, glm::dvec2(0.0)) {
        for (std::size_t i = 0; i < labels.values.size(); ++i) {
            const auto label = labels.values[i];
            if (label >= count) continue;
            pixels[label] += 1.0;
            grey[label] += static_cast<double>(now.grey.values[i]);
            const auto angle = static_cast<double>(now.angle.values[i]);
            if (angle != 0.0) direction[label] += glm::dvec2(std::cos(2.0 * angle), std::sin(2.0 * angle));
        }
        for (std::uint32_t label = 0; label < count; ++label) {
            grey[label] /= std::max(pixels[label], 1.0);
            const double length = glm::length(direction[label]);
            if (length > 0.0) direction[label] /= length;
        }
    }
    bool has(std::uint32_t label, double pixelGrey, double angle) const {
        const GrowOptions options;
        if (std::abs(pixelGrey - grey[label]) > outgrown * options.grey) return false;
        const double cosine =
            direction[label].x * std::cos(2.0 * angle) + direction[label].y * std::sin(2.0 * angle);
        return angle == 0.0 || direction[label] == glm::dvec2(0.0) ||
               cosine >= std::cos(2.0 * outgrown * options.angle);
    }
};

/// Where a region lay before.
struct Origin {
    std::uint32_t label = nowhere;  // of most of it (Boyer and Moore 1991, MJRTY)
    std::uint32_t votes = 0;
    double pixels = 0.0, carried = 0.0;
    glm::dvec2 now{0.0}, then{0.0};  // sums of places

    void vote(std::uint32_t one) {
        if (votes == 0) label = one;
        votes = one == label ? votes + 1 : votes - 1;
    }
};

glm::dvec2 middleOf(std::size_t pixel, std::uint32_t width) {
    return {static_cast<double>(pixel % width) + 0.5, static_cast<double>(pixel / width) + 0.5};
}

std::vector<Origin> originsOf(const Segments& regions, const Raster<std::uint32_t>& from,
                              const Segments& before) {
    std::vector<Origin> origins(regions.count);
    const auto eachPixel = [&](const auto& take) {
        for (std::size_t i = 0; i < from.values.size(); ++i) {
            const auto region = regions.label.values[i];
            if (region >= regions.count) continue;
            const auto pixel = from.values[i];
            take(i, origins[region], pixel, pixel == nowhere ? nowhere : before.label.values[pixel]);
        }
    };
    eachPixel([](std::size_t, Origin& origin, std::uint32_t, std::uint32_t label) {
        origin.pixels += 1.0;
        if (label != nowhere) origin.vote(label);
    });
    eachPixel([&](std::size_t i, Origin& origin, std::uint32_t pixel, std::uint32_t label) {
        if (label == nowhere || label != origin.label) return;
        origin.carried += 1.0;
        origin.now += middleOf(i, from.width);
        origin.then += middleOf(pixel, before.label.width);
    });
    return origins;
}

/// Strokes of a region that moved as its middle did. `scale`: of the picture to the one before.
HatchAxes moved(const HatchAxes& before, const HatchAxes& asked, const Origin& origin, double scale) {
    // Directions have no sign.
    const double turn = std::remainder(asked.direction - before.direction, std::numbers::pi);
    if (std::abs(turn) > otherWay) return asked;
    const double by = std::clamp(turn, -mostTurn, mostTurn);
    const glm::dvec2 now = origin.now / origin.carried, then = origin.then / origin.carried;
    const glm::dvec2 off = scale * (before.origin - then);
    const double cosine = std::cos(by), sine = std::sin(by);
    return {before.direction + by,
            now + glm::dvec2(cosine * off.x - sine * off.y, sine * off.x + cosine * off.y)};
}

}  // namespace

template <class Take>
void LineMap::eachPart(const Take& take) const {
    for (std::uint32_t i = 0; i < parts_.size(); ++i) {
        const glm::dvec2 from(parts_[i].from), to(parts_[i].to);
        eachSquare(from / square, to / square, columns_, rows_,
                   [&](std::uint32_t column, std::uint32_t row, double) {
                       take(std::size_t{row} * columns_ + column, i);
                   });
    }
}

LineMap::LineMap(const std::vector<InkLine>& drawn, const std::vector<InkLine>& left, std::uint32_t width,
                 std::uint32_t height)
    : columns_(static_cast<std::uint32_t>(std::ceil(width / square))),
      rows_(static_cast<std::uint32_t>(std::ceil(height / square))),
      begins_(std::size_t{columns_} * rows_ + 1, 0) {
    const auto add = [&](const std::vector<InkLine>& lines, LineBefore state) {
        for (const auto& line : lines) {
            for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
                const auto &a = line.points[i], &b = line.points[i + 1];
                parts_.push_back(
                    {a.at, b.at, static_cast<float>(a.depth), static_cast<float>(b.depth), state});
            }
        }
    };
    add(drawn, LineBefore::drawn);
    add(left, LineBefore::left);
    eachPart([&](std::size_t at, std::uint32_t) { ++begins_[at + 1]; });
    std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
    inside_.resize(begins_.back());
    auto next = begins_;
    eachPart([&](std::size_t at, std::uint32_t i) { inside_[next[at]++] = i; });
}

LineBefore LineMap::at(const PicturePlace& place, const glm::dvec2& direction, double alike) const {
    auto state = LineBefore::unknown;
    double least = 1.0;
    const auto compare = [&](const Part& part) {
        const glm::dvec2 from(part.from), way = glm::dvec2(part.to) - from;
        const double length = glm::length(way);
        if (!(std::abs(glm::dot(way, direction)) >= leastCosine * length)) return;
        const double share =
            length > 0.0 ? std::clamp(glm::dot(place.at - from, way) / (length * length), 0.0, 1.0) : 0.0;
        const double off = glm::distance(place.at, from + share * way) / reach;
        const double depth =
            std::lerp(static_cast<double>(part.depthFrom), static_cast<double>(part.depthTo), share);
        const double difference = off * off + std::pow((depth - place.depth) / alike, 2.0);
        if (!(difference < least)) return;
        least = difference;
        state = part.state;
    };
    const auto held = [](double at, std::uint32_t count) {
        return static_cast<std::uint32_t>(std::clamp(std::floor(at / square), 0.0, count - 1.0));
    };
    if (columns_ == 0 || rows_ == 0) return state;
    for (auto row = held(place.at.y - reach, rows_); row <= held(place.at.y + reach, rows_); ++row) {
        for (auto column = held(place.at.x - reach, columns_); column <= held(place.at.x + reach, columns_);
             ++column) {
            const std::size_t at = std::size_t{row} * columns_ + column;
            for (auto i = begins_[at]; i < begins_[at + 1]; ++i) compare(parts_[inside_[i]]);
        }
    }
    return state;
}

Carry::Carry(const Modalities& now, const InkCamera& camera, const InkMemory& before)
    : now_(now),
      before_(before),
      motion_(camera, before.camera),
      lines_(before.drawn, before.left, before.depth.width, before.depth.height),
      from_(seenBefore(now, motion_, before)) {}

LineBefore Carry::segmentBefore(const LinePoint& from, const LinePoint& to) const {
    const auto a = motion_({from.at, from.depth}), b = motion_({to.at, to.depth});
    const double length = glm::distance(a.at, b.at);
    if (!std::isfinite(length)) return LineBefore::unknown;
    const glm::dvec2 direction = length > 0.0 ? (b.at - a.at) / length : glm::dvec2(0.0);
    std::array<int, 3> counts{};
    for (const double share : {1.0 / 6.0, 0.5, 5.0 / 6.0}) {
        const PicturePlace place{glm::mix(a.at, b.at, share), std::lerp(a.depth, b.depth, share)};
        const auto state = lines_.at(place, direction, alikeLine * before_.extent);
        ++counts[static_cast<std::size_t>(state)];
    }
    return static_cast<LineBefore>(std::max_element(counts.begin(), counts.end()) - counts.begin());
}

std::vector<std::vector<LineBefore>> Carry::linesBefore(const std::vector<InkLine>& lines) const {
    std::vector<std::vector<LineBefore>> states(lines.size());
    forInTurns(std::size_t{0}, lines.size(), [&](std::size_t i) {
        const auto& points = lines[i].points;
        for (std::size_t k = 0; k + 1 < points.size(); ++k)
            states[i].push_back(segmentBefore(points[k], points[k + 1]));
    });
    return states;
}

Segments Carry::regions(const Segments& found, std::size_t leastPixels, const std::stop_token& stop) const {
    if (before_.regions.label.values.empty()) return found;
    Segments made = found;
    auto carried = from_;
    for (auto& pixel : carried.values) {
        if (pixel != nowhere) pixel = before_.regions.label.values[pixel];
    }
    const std::uint32_t count = before_.regions.count;
    const CarriedMeans means(now_, carried, count);
    for (std::size_t i = 0; i < carried.values.size(); ++i) {
        auto& label = made.label.values[i];
        if (label == Segments::nothing) continue;
        const bool same = carried.values[i] < count &&
                          means.has(carried.values[i], static_cast<double>(now_.grey.values[i]),
                                    static_cast<double>(now_.angle.values[i]));
        label = same ? carried.values[i] : count + label;
    }
    made.count = count + found.count;
    // What lies apart in depth, or is of other parts, is no region of one label.
    const auto depth = growDepth(now_, GrowOptions().depth, stop);
    made = withoutSmall(intersected(made, depth, {now_.part, 0}, stop), now_, leastPixels, stop);
    if (isStopped(stop)) return {};
    return made;
}

std::vector<HatchAxes> Carry::axes(const Segments& regions, const std::vector<HatchAxes>& asked) const {
    if (before_.regions.label.values.empty() || regions.label.values.empty()) return asked;
    const auto origins = originsOf(regions, from_, before_.regions);
    auto axes = asked;
    const double scale = static_cast<double>(from_.height) / before_.depth.height;
    for (std::size_t i = 0; i < axes.size(); ++i) {
        const auto& origin = origins[i];
        if (origin.label < before_.axes.size() && origin.carried > mostShare * origin.pixels)
            axes[i] = moved(before_.axes[origin.label], asked[i], origin, scale);
    }
    return axes;
}

void Carry::even(Raster<float>& density) const {
    if (before_.density.values.empty()) return;
    for (std::size_t i = 0; i < density.values.size(); ++i) {
        if (from_.values[i] == nowhere) continue;
        density.values[i] += kept * (before_.density.values[from_.values[i]] - density.values[i]);
    }
}

}  // namespace mote::render
