// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/flat_picture.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "server/render/blank_picture.h"

namespace mote::render {
namespace {

using Pixel = std::array<std::uint8_t, 8>;

/// Turns a pixel's count into its bytes.
class PixelBytes {
  public:
    PixelBytes(const FramePlan& plan, const PointsPlan& only, const FlatPoints& points, PixelFormat format)
        : background_(plan.background), color_(only.look.color), format_(format) {
        const double size = std::min(only.look.size, 1.0);
        tau_ = -std::log1p(-only.look.opacity * size * size) * points.weightOfOne();
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
    double tau_;
    bool solid_;
    std::vector<Pixel> known_;
};

template <std::size_t bytes>
void fill(const PixelBytes& shades, std::span<const std::uint32_t> counts, std::uint8_t* pixels) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, counts.size(), 1 << 14), [&](const auto& block) {
        for (std::size_t i = block.begin(); i < block.end(); ++i) {
            std::memcpy(pixels + i * bytes, shades(counts[i]).data(), bytes);
        }
    });
}

}  // namespace

std::optional<std::uint32_t> flatPoints(const FramePlan& plan, const std::vector<VisibleField>& fields) {
    const bool seen = std::any_of(fields.begin(), fields.end(),
                                  [](const VisibleField& field) { return field.volume != nullptr; });
    if (plan.anyDots() || plan.densities() < plan.fields.size() || seen) return std::nullopt;
    std::optional<std::uint32_t> only;
    for (std::uint32_t i = 0; i < plan.points.size(); ++i) {
        if (plan.points[i].pointsDrawn == 0) continue;
        if (only) return std::nullopt;
        only = i;
    }
    return only;
}

Picture flatPicture(const FramePlan& plan, const PointsPlan& only, const FlatPoints& points,
                    PixelFormat format) {
    Picture picture{.width = plan.width,
                    .height = plan.height,
                    .format = format,
                    .pixels = {},
                    .pointsDrawn = points.pointsDrawn()};
    picture.pixels.resize(points.counts().size() * bytesPerPixel(format));
    const PixelBytes shades(plan, only, points, format);
    if (format == PixelFormat::srgb8) {
        fill<4>(shades, points.counts(), picture.pixels.data());
    } else {
        fill<8>(shades, points.counts(), picture.pixels.data());
    }
    return picture;
}

}  // namespace mote::render
