// SPDX-License-Identifier: GPL-3.0-or-later
//
// A colour becomes a mix of two of the palette's: the one nearest to it, and the one that together with it
// comes nearest. Where a cell of 8 x 8 pixels has how much of the second one is Bayer's ordering.
#include "client/frames/video/gif_palette.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "protocol/base/mote_check.h"

namespace mote::client {
namespace {

constexpr std::uint32_t known = 1U << 24;
constexpr double levels = 64;        // of the pattern
constexpr double grainWeight = 0.1;  // how much a mix of colours far apart counts against it

/// 0 to 63, each once in 8 x 8 pixels.
constexpr std::uint32_t bayer(std::uint32_t x, std::uint32_t y) {
    std::uint32_t value = 0;
    for (std::uint32_t bit = 0; bit < 3; ++bit) {
        const std::uint32_t a = x >> bit & 1, b = y >> bit & 1;
        value = value << 2 | (a ^ b) << 1 | b;
    }
    return value;
}

constexpr auto pattern = [] {
    std::array<std::array<std::uint8_t, 8>, 8> rows{};
    for (std::uint32_t y = 0; y < 8; ++y) {
        for (std::uint32_t x = 0; x < 8; ++x) rows[y][x] = static_cast<std::uint8_t>(bayer(x, y));
    }
    return rows;
}();

SeenColor minus(const SeenColor& a, const SeenColor& b) {
    return {a.luma - b.luma, a.cb - b.cb, a.cr - b.cr};
}

double dot(const SeenColor& a, const SeenColor& b) {
    return a.luma * b.luma + a.cb * b.cb + a.cr * b.cr;
}

}  // namespace

SeenColor seenColor(double r, double g, double b) {
    constexpr double chroma = 0.7071067811865476;  // half the weight of a square
    const double luma = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    return {luma, chroma * (b - luma) / 1.8556, chroma * (r - luma) / 1.5748};
}

double squareDistance(const SeenColor& a, const SeenColor& b) {
    const auto d = minus(a, b);
    return dot(d, d);
}

GifDither::GifDither(const GifPalette& palette) : mixes_(std::size_t{1} << 24) {
    MOTE_CHECK(!palette.colors.empty() && palette.colors.size() <= GifPalette::mostColors);
    for (const auto& [r, g, b] : palette.colors) colors_.push_back(seenColor(r, g, b));
}

/// The nearest colour's index, the other's, and how many of 64 pixels are of the other.
std::uint32_t GifDither::mixOf(std::uint32_t rgb) {
    const auto wanted = seenColor(rgb & 255, rgb >> 8 & 255, rgb >> 16 & 255);
    const auto nearest = std::min_element(colors_.begin(), colors_.end(), [&](const auto& a, const auto& b) {
        return squareDistance(a, wanted) < squareDistance(b, wanted);
    });
    const auto off = minus(wanted, *nearest);
    std::uint32_t other = 0, share = 0;
    double least = dot(off, off);
    for (std::size_t i = 0; i < colors_.size() && least > 0; ++i) {
        const auto way = minus(colors_[i], *nearest);
        const double length = dot(way, way);
        if (length <= 0) continue;
        const double at = std::clamp(dot(off, way) / length, 0.0, 0.5);
        const auto miss = SeenColor{off.luma - at * way.luma, off.cb - at * way.cb, off.cr - at * way.cr};
        const double cost = dot(miss, miss) + grainWeight * at * (1 - at) * length;
        if (cost >= least) continue;
        least = cost;
        other = static_cast<std::uint32_t>(i);
        share = static_cast<std::uint32_t>(at * levels + 0.5);
    }
    return known | share << 16 | other << 8 | static_cast<std::uint32_t>(nearest - colors_.begin());
}

void GifDither::row(std::uint32_t y, std::span<const std::uint8_t> rgba, std::uint8_t* indices) {
    const auto& thresholds = pattern[y % 8];
    for (std::size_t i = 0; 4 * i < rgba.size(); ++i) {
        const std::uint32_t rgb =
            rgba[4 * i] | std::uint32_t{rgba[4 * i + 1]} << 8 | std::uint32_t{rgba[4 * i + 2]} << 16;
        auto& mix = mixes_[rgb];
        if (mix == 0) mix = mixOf(rgb);
        const bool second = thresholds[i % 8] < (mix >> 16 & 255);
        indices[i] = static_cast<std::uint8_t>(second ? mix >> 8 : mix);
    }
}

namespace {

constexpr int cellBits = 6;  // of each channel
constexpr int rounds = 8;    // of moving colours: more change nothing that is seen

struct Sample {
    SeenColor seen;
    double r = 0, g = 0, b = 0;
    double weight = 0;
};

using Samples = std::span<Sample>;

std::array<double, 3> axes(const Sample& sample) {
    return {sample.seen.luma, sample.seen.cb, sample.seen.cr};
}

/// A part of the set, and where to halve it.
struct Part {
    explicit Part(Samples all) : samples(all) {
        std::array<double, 3> sum{}, square{};
        double weight = 0;
        for (const auto& sample : samples) {
            const auto at = axes(sample);
            weight += sample.weight;
            for (std::size_t i = 0; i < 3; ++i) {
                sum[i] += sample.weight * at[i];
                square[i] += sample.weight * at[i] * at[i];
            }
        }
        for (std::size_t i = 0; i < 3; ++i) {
            const double spread = square[i] - sum[i] * sum[i] / weight;
            if (samples.size() > 1 && spread > widest) {
                widest = spread;
                axis = i;
                middle = sum[i] / weight;
            }
        }
    }

    Samples samples;
    double widest = 0;  ///< weighted square sum about the mean along `axis`; 0: cannot be halved
    std::size_t axis = 0;
    double middle = 0;
};

RgbColor meanOf(double r, double g, double b, double weight) {
    const auto byte = [&](double sum) { return static_cast<std::uint8_t>(sum / weight + 0.5); };
    return {byte(r), byte(g), byte(b)};
}

RgbColor meanOf(Samples samples) {
    double r = 0, g = 0, b = 0, weight = 0;
    for (const auto& sample : samples) {
        r += sample.weight * sample.r;
        g += sample.weight * sample.g;
        b += sample.weight * sample.b;
        weight += sample.weight;
    }
    return meanOf(r, g, b, weight);
}

std::vector<RgbColor> halve(Samples all) {
    std::vector<Part> parts{Part(all)};
    while (parts.size() < GifPalette::mostColors) {
        const auto widest = std::max_element(
            parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.widest < b.widest; });
        if (widest->widest <= 0) break;
        const auto split = *widest;
        const auto second = std::stable_partition(
            split.samples.begin(), split.samples.end(),
            [&](const auto& sample) { return axes(sample)[split.axis] <= split.middle; });
        const auto count = static_cast<std::size_t>(second - split.samples.begin());
        if (count == 0 || count == split.samples.size()) {  // by rounding alone
            widest->widest = 0;
            continue;
        }
        *widest = Part(split.samples.first(count));
        parts.emplace_back(split.samples.subspan(count));
    }
    std::vector<RgbColor> colors;
    for (const auto& part : parts) colors.push_back(meanOf(part.samples));
    return colors;
}

/// Each colour into the middle of the samples that it is nearest to.
void settle(std::vector<RgbColor>& colors, std::span<const Sample> samples) {
    std::vector<SeenColor> seen;
    for (const auto& [r, g, b] : colors) seen.push_back(seenColor(r, g, b));
    std::vector<std::array<double, 4>> sums(colors.size());
    for (const auto& sample : samples) {
        std::size_t nearest = 0;
        double least = squareDistance(seen[0], sample.seen);
        for (std::size_t i = 1; i < seen.size(); ++i) {
            const double distance = squareDistance(seen[i], sample.seen);
            if (distance < least) {
                least = distance;
                nearest = i;
            }
        }
        const std::array<double, 4> values{sample.r, sample.g, sample.b, 1};
        for (std::size_t i = 0; i < 4; ++i) sums[nearest][i] += sample.weight * values[i];
    }
    for (std::size_t i = 0; i < colors.size(); ++i) {
        if (sums[i][3] > 0) colors[i] = meanOf(sums[i][0], sums[i][1], sums[i][2], sums[i][3]);
    }
}

std::uint32_t cellOf(std::uint32_t rgb) {
    constexpr int drop = 8 - cellBits;
    constexpr std::uint32_t most = (1U << cellBits) - 1;
    return (rgb >> drop & most) | (rgb >> (8 + drop) & most) << cellBits |
           (rgb >> (16 + drop) & most) << (2 * cellBits);
}

RgbColor unpack(std::uint32_t rgb) {
    return {static_cast<std::uint8_t>(rgb), static_cast<std::uint8_t>(rgb >> 8),
            static_cast<std::uint8_t>(rgb >> 16)};
}

}  // namespace

PaletteMaker::PaletteMaker() : cells_(std::size_t{1} << (3 * cellBits)) {}

void PaletteMaker::add(std::span<const std::uint8_t> rgba) {
    std::uint32_t before = ~0U;
    for (std::size_t i = 0; i + 4 <= rgba.size(); i += 4) {
        const std::uint32_t r = rgba[i], g = rgba[i + 1], b = rgba[i + 2], rgb = r | g << 8 | b << 16;
        auto& cell = cells_[cellOf(rgb)];
        ++cell.count;
        cell.r += r;
        cell.g += g;
        cell.b += b;
        if (!few_ || rgb == before) continue;
        before = rgb;
        const auto at = std::lower_bound(exact_.begin(), exact_.end(), rgb);
        if (at == exact_.end() || *at != rgb) exact_.insert(at, rgb);
        few_ = exact_.size() <= GifPalette::mostColors;
    }
}

GifPalette PaletteMaker::make() const {
    GifPalette palette;
    if (few_) {
        for (const auto rgb : exact_) palette.colors.push_back(unpack(rgb));
        if (palette.colors.empty()) palette.colors.push_back({});
        return palette;
    }
    std::vector<Sample> samples;
    for (const auto& cell : cells_) {
        if (cell.count == 0) continue;
        const auto count = static_cast<double>(cell.count);
        const double r = static_cast<double>(cell.r) / count, g = static_cast<double>(cell.g) / count,
                     b = static_cast<double>(cell.b) / count;
        // The root: what is rare and lies apart, as the halo's particles do, gets its colours too.
        samples.push_back({seenColor(r, g, b), r, g, b, std::sqrt(count)});
    }
    palette.colors = halve(samples);
    for (int i = 0; i < rounds; ++i) settle(palette.colors, samples);
    return palette;
}

}  // namespace mote::client
