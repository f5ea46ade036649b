// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/flat_points.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

#include "protocol/scene/srgb.h"
#include "server/render/blank_picture.h"
#include "server/render/cpu/point_footprint.h"
#include "server/render/cpu/point_stream.h"
#include "server/render/cpu/points_kernel.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/long_list.h"

namespace mote::render {
namespace {

/// Leaves that a thread takes at a time: some hundred kilobytes of points.
constexpr std::size_t flatLeaves = 4096;
/// Room for the counts of all threads, bytes: of very large pictures fewer threads count.
constexpr std::size_t countBytes = std::size_t{1} << 30;

/// What a disc of full coverage counts: of an opaque one a step of its edge's optical depth, of which there
/// is much, must not be seen either. Few enough that counts saturate only where all is opaque.
double discUnit(const PointLook& look) {
    constexpr double least = 256.0, most = 8192.0, stepsOfDepth = 512.0;
    return std::round(std::clamp(look.tauAt(1.0, false) * look.thinned * stepsOfDepth, least, most));
}

/// So that a sum never wraps and does not depend on its order.
std::uint32_t saturatingSum(std::uint32_t a, std::uint32_t b) {
    const std::uint32_t sum = a + b;
    return sum < a ? std::numeric_limits<std::uint32_t>::max() : sum;
}

/// One picture being counted.
class Counting {
  public:
    /// `cells`: the leaves'; `blocks`: points told in the whole box.
    Counting(const PointsPlan& layer, const PointMap& map, std::span<const LeafCell> cells,
             const PreviewBlocks& blocks, FullCount full)
        : layer_(layer),
          // Without leaves to draw, the octree need not even be there.
          leaves_(cells.empty() ? storage::Leaves{} : layer.step->leaves()),
          cells_(cells),
          map_(map),
          preview_(blocks),
          full_(full),
          end_(layer.step->positions(0, 0).data() + layer.step->pointCount()) {
        if (layer.look.size > 1.0) {
            const DiscFootprint disc(layer.look.size, layer.look.discOpacity());
            const auto unit = static_cast<float>(discUnit(layer.look));
            discs_.emplace(FlatDiscs{disc.reach(), {}});
            std::transform(disc.weights().begin(), disc.weights().end(), discs_->units.begin(),
                           // As in PointFootprint: NOLINTNEXTLINE(bugprone-incorrect-roundings)
                           [unit](float weight) { return static_cast<std::uint32_t>(weight * unit + 0.5F); });
        }
    }

    /// The leaves' chunks, then the preview's; a plan selects points of one or the other.
    std::size_t chunks() const { return leafChunks() + preview_.count(); }

    /// Returns how many points were drawn.
    std::uint64_t count(std::size_t chunk, std::vector<std::uint32_t>& counts) const {
        return chunk < leafChunks() ? countLeaves(chunk, counts)
                                    : countBlock(preview_.block(chunk - leafChunks()), counts);
    }

  private:
    std::size_t leafChunks() const { return (cells_.size() + flatLeaves - 1) / flatLeaves; }

    std::uint64_t countLeaves(std::size_t chunk, std::vector<std::uint32_t>& counts) const {
        const std::size_t first = chunk * flatLeaves;
        const std::size_t size = std::min(flatLeaves, cells_.size() - first);
        std::array<std::uint32_t, flatLeaves> seen;
        const std::uint32_t* drawn = layer_.selection->drawn.data() + first;
        if (!layer_.leavesInView.empty()) {
            for (std::size_t i = 0; i < size; ++i) seen[i] = layer_.drawn(first + i);
            drawn = seen.data();
        }
        if (std::all_of(drawn, drawn + size, [](std::uint32_t points) { return points == 0; })) return 0;
        const std::uint64_t begin = leaves_.pointBegin[first];
        const std::uint64_t end = leaves_.pointBegin[first + size - 1] + leaves_.pointCount[first + size - 1];
        const LeafRun run{.cells = cells_.data() + first,
                          .drawn = drawn,
                          .count = leaves_.pointCount.data() + first,
                          .points = layer_.step->positions(begin, end - begin).data(),
                          .end = end_,
                          .leaves = size};
        return discs_ ? countDiscs(map_, run, *discs_, full_, counts.data())
                      : countPoints(map_, run, full_, counts.data());
    }

    std::uint64_t countBlock(const PreviewRun& run, std::vector<std::uint32_t>& counts) const {
        if (!discs_) return countPreview(map_, run, counts.data());
        std::array<ScreenPoint, PreviewBlocks::blockPoints> screen;
        const std::size_t hits = projectPreview(map_, run, discs_->reach, screen.data());
        countScreenDiscs(map_, screen.data(), hits, *discs_, counts.data());
        return hits;
    }

    const PointsPlan& layer_;
    const storage::Leaves leaves_;
    const std::span<const LeafCell> cells_;
    const PointMap& map_;
    const PreviewBlocks preview_;
    const FullCount full_;
    std::optional<FlatDiscs> discs_;
    const storage::PackedPosition* end_;
};

std::size_t partsFor(std::size_t pixels) {
    const auto threads = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
    return std::clamp<std::size_t>(countBytes / (pixels * sizeof(std::uint32_t)), 1, threads);
}

using Pixel = std::array<std::uint8_t, 8>;

/// A pixel of sRGB. Linear light is told in steps of a 65535th, a twentieth of a step of the darkest colours.
Pixel encoded(const glm::vec3& light) {
    constexpr float steps = 65535.0F;
    static const auto bytes = [] {
        std::vector<std::uint8_t> table(65536);
        for (std::size_t i = 0; i < table.size(); ++i) {
            const double component = linearToSrgb(static_cast<double>(i) / 65535.0);
            table[i] = static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(component, 0.0, 1.0)));
        }
        return table;
    }();
    const auto byteOf = [](float x) {
        // As in PointFootprint: NOLINTNEXTLINE(bugprone-incorrect-roundings)
        return bytes[static_cast<std::size_t>(std::clamp(x, 0.0F, 1.0F) * steps + 0.5F)];
    };
    return {byteOf(light.x), byteOf(light.y), byteOf(light.z), 255};
}

/// The count that hides all, whatever its colour: what is left is as little as where rays end. `tau`: of a
/// count of one.
double hidingCount(double tau) {
    constexpr double leastLeft = 5e-5;
    return std::ceil(-std::log(leastLeft) / tau);
}

/// Of so much, nothing is left in single precision, whatever the colour.
double mostCount(double tau) {
    constexpr double nothing = 104.0;
    return std::min(std::ceil(nothing / tau), static_cast<double>(neverFull - 1));
}

/// Turns a pixel's count into its bytes.
class PixelBytes {
  public:
    PixelBytes(const FramePlan& plan, const PointsPlan& only, const FlatPoints& points, PixelFormat format)
        : background_(plan.background), color_(only.look.color), format_(format) {
        tau_ = only.look.tauAt(1.0, false) * only.look.thinned * points.weightOfOne();
        fullOfAnyColor_ = hidingCount(tau_);
        // What is left behind so much shows in no pixel of the format.
        const double opaque = format == PixelFormat::srgb8 ? 12.0 : 20.0;
        constexpr double most = 65536.0;
        const auto pixels = static_cast<double>(points.counts().size());
        const double needed = std::min({opaque / std::max(tau_, opaque / most), most, pixels});
        known_.resize(static_cast<std::size_t>(needed) + 1);
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, known_.size(), 256), [this](const auto& block) {
            for (std::size_t i = block.begin(); i < block.end(); ++i)
                known_[i] = shade(static_cast<std::uint32_t>(i));
        });
        solid_ = static_cast<double>(known_.size()) * tau_ >= opaque;
    }

    /// Of points of another colour.
    Pixel operator()(std::uint32_t count, const glm::vec3& color) const {
        const auto passed = count < fullOfAnyColor_ ? static_cast<float>(std::exp(-tau_ * count)) : 0.0F;
        const glm::vec3 light = (1.0F - passed) * color + passed * glm::vec3(background_);
        return format_ == PixelFormat::srgb8 ? encoded(light) : blankPixel(glm::dvec3(light), format_);
    }

    Pixel operator()(std::uint32_t count) const {
        if (count < known_.size()) return known_[count];
        return solid_ ? known_.back() : shade(count);
    }

  private:
    Pixel shade(std::uint32_t count) const {
        const double passed = std::exp(-tau_ * count);
        return blankPixel((1.0 - passed) * color_ + passed * background_, format_);
    }

    glm::dvec3 background_, color_;
    PixelFormat format_;
    double tau_, fullOfAnyColor_;
    bool solid_;
    std::vector<Pixel> known_;
};

template <std::size_t bytes>
void fill(const PixelBytes& shades, std::span<const std::uint32_t> counts, std::uint8_t* pixels) {
    forRangesInTurns(counts.size(), std::size_t{1} << 14, [&](const auto& block) {
        for (std::size_t i = block.begin(); i < block.end(); ++i) {
            std::memcpy(pixels + i * bytes, shades(counts[i]).data(), bytes);
        }
    });
}

void fillColored(const PixelBytes& shades, const FlatPoints& points, const PixelColors& colors,
                 PixelFormat format, std::uint8_t* pixels) {
    const std::size_t bytes = bytesPerPixel(format);
    forInTurns(std::uint32_t{0}, colors.height(), [&](std::uint32_t row) {
        for (std::uint32_t column = 0; column < colors.width(); ++column) {
            const std::size_t i = std::size_t{row} * colors.width() + column;
            const std::uint32_t count = points.counts()[i];
            const Pixel pixel = count == 0 ? shades(0) : shades(count, colors.at(column, row));
            std::memcpy(pixels + i * bytes, pixel.data(), bytes);
        }
    });
}

/// Of how much the picture has the bytes of any more. `tau`: of a count of one.
FullCount fullCount(const FramePlan& plan, const PointLook& look, double tau, const PixelColors* colors,
                    PixelFormat format) {
    const auto passed = [tau](double count) { return std::exp(-tau * count); };
    if (!(tau > 0.0)) return neverFull;
    const double most = mostCount(tau);
    if (colors != nullptr) return static_cast<FullCount>(std::min(hidingCount(tau), most));
    const auto pixel = [&](double left) {
        return blankPixel((1.0 - left) * look.color + left * plan.background, format);
    };
    const auto last = pixel(0.0);
    std::uint32_t shown = 0, full = static_cast<FullCount>(most);
    if (pixel(passed(full)) != last) return neverFull;
    while (full - shown > 1) {
        const std::uint32_t middle = shown + (full - shown) / 2;
        (pixel(passed(middle)) == last ? full : shown) = middle;
    }
    return full;
}

/// Whether so many points may fill enough pixels that looking for full ones takes less than it saves. They
/// lie in a part of the picture only; discs take longer than any look.
bool mayFill(const FramePlan& plan, const PointsPlan& layer, FullCount full) {
    constexpr double mostEmpty = 16.0;  // pixels of the picture, to one that has points
    const double pixels = static_cast<double>(plan.width) * plan.height;
    return layer.look.size > 1.0 ||
           mostEmpty * static_cast<double>(layer.pointsDrawn) > static_cast<double>(full) * pixels;
}

}  // namespace

bool FlatPoints::draw(const FramePlan& plan, const PointsPlan& layer, std::span<const LeafCell> cells,
                      const PixelColors* colors, PixelFormat format, const std::stop_token& stop) {
    const std::size_t pixels = std::size_t{plan.width} * plan.height;
    const PointMap map = PointMap::make(plan, layer);
    const bool stream = PointStream::serves(plan, layer, map);
    weightOfOne_ = layer.look.size > 1.0 ? 1.0 / discUnit(layer.look) : 1.0;
    const double tau = layer.look.tauAt(1.0, false) * layer.look.thinned * weightOfOne_;
    const FullCount full = fullCount(plan, layer.look, tau, colors, format);
    const Counting counting(layer, map, stream ? std::span<const LeafCell>() : cells,
                            stream ? PreviewBlocks(stream_.of(layer, cells)) : PreviewBlocks(layer),
                            mayFill(plan, layer, full) ? full : neverFull);
    parts_.resize(partsFor(pixels) - 1);
    pixels_ = pixels;
    const auto countsOf = [this](std::size_t part) -> std::vector<std::uint32_t>& {
        return part == 0 ? counts_ : parts_[part - 1];
    };
    const std::size_t parts = parts_.size() + 1;
    forInTurns(std::size_t{0}, parts,
               [&](std::size_t part) { countsOf(part).assign(pixels + spareCounts, 0); });
    std::atomic<std::uint64_t> drawn{0};
    forPartsInTurns(parts, counting.chunks(), stop, [&](std::size_t part, std::size_t chunk) {
        drawn += counting.count(chunk, countsOf(part));
    });
    pointsDrawn_ = drawn;
    if (stop.stop_requested()) return false;
    forRangesInTurns(pixels, std::size_t{1} << 14, [&](const auto& block) {
        for (const auto& part : parts_) {
            for (std::size_t i = block.begin(); i < block.end(); ++i)
                counts_[i] = saturatingSum(counts_[i], part[i]);
        }
    });
    return true;
}

FullCount fullOfAnyColor(const PointLook& look) {
    const double tau = look.tauAt(1.0, false) * look.thinned;
    return tau > 0.0 ? static_cast<FullCount>(std::min(hidingCount(tau), mostCount(tau))) : neverFull;
}

void FlatPoints::take(std::span<const std::uint32_t> counts, std::uint64_t drawn) {
    pixels_ = counts.size();
    counts_.assign(counts.begin(), counts.end());
    weightOfOne_ = 1.0;
    pointsDrawn_ = drawn > 0 ? drawn : std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
}

std::optional<std::uint32_t> flatPoints(const FramePlan& plan, const std::vector<VisibleField>& fields) {
    const bool seen = std::any_of(fields.begin(), fields.end(),
                                  [](const VisibleField& field) { return field.volume != nullptr; });
    if (plan.anyDots() || plan.densities() < plan.fields.size() || seen) return std::nullopt;
    std::optional<std::uint32_t> only;
    for (std::uint32_t i = 0; i < plan.points.size(); ++i) {
        if (plan.points[i].pointsDrawn == 0) continue;
        if (only || !plan.points[i].alike(plan.camera.perspective())) return std::nullopt;
        only = i;
    }
    return only;
}

Picture flatPicture(const FramePlan& plan, const PointsPlan& only, const FlatPoints& points,
                    const PixelColors* colors, PixelFormat format) {
    Picture picture{.width = plan.width,
                    .height = plan.height,
                    .format = format,
                    .pixels = {},
                    .pointsDrawn = points.pointsDrawn()};
    resizeInTurns(picture.pixels, points.counts().size() * bytesPerPixel(format));
    const PixelBytes shades(plan, only, points, format);
    if (colors != nullptr) {
        fillColored(shades, points, *colors, format, picture.pixels.data());
    } else if (format == PixelFormat::srgb8) {
        fill<4>(shades, points.counts(), picture.pixels.data());
    } else {
        fill<8>(shades, points.counts(), picture.pixels.data());
    }
    return picture;
}

}  // namespace mote::render
