// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/numbers/histogram_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "protocol/base/mote_check.h"
#include "protocol/scene/srgb.h"

namespace mote::client {
namespace {

constexpr std::size_t colorCount = 256;
constexpr double leastShare = 0.08;  // of the map: the weakest bin still stands out from the ground

using Color = std::array<std::uint8_t, 4>;

std::vector<Color> tableOf(const ColorMap& map) {
    std::vector<Color> table;
    for (std::size_t i = 0; i < colorCount; ++i) {
        const auto color = linearToSrgb(map(static_cast<double>(i) / (colorCount - 1)));
        Color bytes{0, 0, 0, 255};
        for (int c = 0; c < 3; ++c)
            bytes[static_cast<std::size_t>(c)] =
                static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(color[c], 0.0, 1.0)));
        table.push_back(bytes);
    }
    return table;
}

/// Where in the map a count lies.
class CountScale {
  public:
    CountScale(const std::vector<double>& counts, bool logScale) : log_(logScale) {
        for (const double count : counts) {
            if (!(count > 0.0) || !std::isfinite(count)) continue;
            least_ = std::min(least_, count);
            most_ = std::max(most_, count);
        }
    }
    double operator()(double count) const {
        if (!(count < most_)) return 1.0;
        const double part = log_ ? (std::log(count) - std::log(least_)) / (std::log(most_) - std::log(least_))
                                 : count / most_;
        return leastShare + (1.0 - leastShare) * std::clamp(part, 0.0, 1.0);
    }

  private:
    bool log_;
    double least_ = std::numeric_limits<double>::max(), most_ = 0.0;
};

}  // namespace

HistogramPicture pictureOf(const StepHistogram& histogram, const ColorMap& map, bool logScale) {
    MOTE_CHECK(histogram.edges.size() == 2);
    const auto width = histogram.bins(0), height = histogram.bins(1);
    HistogramPicture picture{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), {}};
    picture.pixels.resize(4 * width * height);
    const auto table = tableOf(map);
    const CountScale scale(histogram.counts, logScale);
    for (std::size_t x = 0; x < width; ++x) {
        for (std::size_t y = 0; y < height; ++y) {
            const double count = histogram.counts[x * height + y];
            if (!(count > 0.0)) continue;
            const auto index = static_cast<std::size_t>(std::lround(scale(count) * (colorCount - 1)));
            std::ranges::copy(table[index], picture.pixels.begin() + static_cast<std::ptrdiff_t>(
                                                                         4 * ((height - 1 - y) * width + x)));
        }
    }
    return picture;
}

std::vector<double> marginalOf(const StepHistogram& histogram, std::size_t column) {
    MOTE_CHECK(histogram.edges.size() == 2 && column < 2);
    std::vector<double> sums(histogram.bins(column), 0.0);
    const auto height = histogram.bins(1);
    for (std::size_t i = 0; i < histogram.counts.size(); ++i)
        sums[column == 0 ? i / height : i % height] += histogram.counts[i];
    return sums;
}

}  // namespace mote::client
