// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/stipple/tone.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "server/render/plan/in_turns.h"
#include "server/render/plan/long_list.h"

namespace mote::render {
namespace {

/// Density by luminance, so that no pixel needs a power.
class ToneTable {
  public:
    explicit ToneTable(const PhotographTone& tone) {
        const double cover = tone.fullDensity() * std::numbers::pi / 4.0 * tone.dot * tone.dot;
        const double fullInk = inkOfCover(cover);
        for (std::size_t i = 0; i < densities_.size(); ++i) {
            const double luminance = static_cast<double>(i) / last;
            const double brightness = std::pow(luminance, tone.gamma);
            const double ink = fullInk * (tone.denseDark ? 1.0 - brightness : brightness);
            densities_[i] = static_cast<float>(std::min(densityOfInk(ink, tone.dot), tone.fullDensity()));
        }
    }

    float operator()(double luminance) const {
        const double at = std::clamp(luminance, 0.0, 1.0) * last;
        const auto below = std::min(static_cast<std::size_t>(at), densities_.size() - 2);
        const auto part = static_cast<float>(at - static_cast<double>(below));
        return densities_[below] + part * (densities_[below + 1] - densities_[below]);
    }

  private:
    static constexpr double last = 4096.0;
    std::array<float, 4097> densities_{};
};

struct Knot {
    double cover;
    double ink;
};

/// Measured on dots of plane hierarchies (tests/bench/stipple_tone --levels); linear between.
constexpr std::array<Knot, 14> knots{{{0.0, 0.0},
                                      {0.5, 0.5},
                                      {0.6, 0.597},
                                      {0.7, 0.689},
                                      {0.8, 0.770},
                                      {0.9, 0.837},
                                      {1.0, 0.888},
                                      {1.1, 0.925},
                                      {1.2, 0.951},
                                      {1.3, 0.9685},
                                      {1.4, 0.980},
                                      {1.5, 0.988},
                                      {1.6, 0.993},
                                      {solidCover, 1.0}}};

}  // namespace

double PhotographTone::fullDensity() const {
    return densityOfSpacing(spacing);
}

PictureFit PictureFit::within(std::uint32_t width, std::uint32_t height, const PixelMap& picture) {
    PictureFit fit;
    fit.scale = std::min(static_cast<double>(width) / picture.width(),
                         static_cast<double>(height) / picture.height());
    fit.left = 0.5 * (width - fit.scale * picture.width());
    fit.top = 0.5 * (height - fit.scale * picture.height());
    return fit;
}

PixelMap wantedDensity(const PixelMap& luminance, std::uint32_t width, std::uint32_t height,
                       const PhotographTone& tone) {
    const ToneTable table(tone);
    const auto fit = PictureFit::within(width, height, luminance);
    const double step = 1.0 / fit.scale;  // pixels of the photograph a pixel of the picture
    auto density = listInTurns<float>(std::size_t{width} * height);
    using Range = tbb::blocked_range<std::size_t>;
    forRangesInTurns(height, 32, [&](const Range& rows) {
        for (auto y = rows.begin(); y != rows.end(); ++y) {
            const double v = (static_cast<double>(y) + 0.5 - fit.top) * step;
            if (v < 0.0 || v >= luminance.height()) continue;
            for (std::size_t x = 0; x < width; ++x) {
                const double u = (static_cast<double>(x) + 0.5 - fit.left) * step;
                if (u < 0.0 || u >= luminance.width()) continue;
                density[y * width + x] = table(luminance.mean(u, v, step));
            }
        }
    });
    return {width, height, std::move(density)};
}

double inkOfCover(double phi) {
    if (phi >= solidCover) return 1.0;
    const auto above =
        std::find_if(knots.begin() + 1, knots.end(), [&](const Knot& k) { return phi < k.cover; });
    const auto below = above - 1;
    return below->ink +
           (std::max(phi, 0.0) - below->cover) * (above->ink - below->ink) / (above->cover - below->cover);
}

double coverOfInk(double ink) {
    if (ink >= 1.0) return solidCover;
    const auto above =
        std::find_if(knots.begin() + 1, knots.end(), [&](const Knot& k) { return ink < k.ink; });
    const auto below = above - 1;
    return below->cover +
           (std::max(ink, 0.0) - below->ink) * (above->cover - below->cover) / (above->ink - below->ink);
}

double densityOfInk(double ink, double dot) {
    return coverOfInk(ink) / (std::numbers::pi / 4.0 * dot * dot);
}

double densityOfSpacing(double spacing) {
    return 2.0 / (std::numbers::sqrt3 * spacing * spacing);
}

}  // namespace mote::render
