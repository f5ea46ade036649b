// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/image/lower_image.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "protocol/scene/space/picture_plane.h"
#include "server/render/plan/frame_plan.h"

namespace mote::render {
namespace {

constexpr double behindAll = std::numeric_limits<double>::infinity();

/// What the pixels of a picture's side see of an image's: how much of each it covers, and the means of which
/// of its pixels they show.
class SideShares {
  public:
    /// `side`: pixels of the picture. `extent`: of the image, of which `count` are held. `scale`: pixels of
    /// the picture to one of the image, which lies in the middle.
    SideShares(std::uint32_t side, double extent, std::uint32_t count, double scale)
        : begin_(side + std::size_t{1}, 0), first_(side, 0), covered_(side, 0.0F) {
        const double start = 0.5 * (side - scale * extent);
        const double half = 0.5 * std::max(1.0, 1.0 / scale);
        for (std::uint32_t pixel = 0; pixel < side; ++pixel) {
            const double from = std::max<double>(pixel, start);
            const double to = std::min<double>(pixel + 1.0, start + scale * extent);
            covered_[pixel] = static_cast<float>(std::clamp(to - from, 0.0, 1.0));
            if (covered_[pixel] > 0.0F) add(pixel, (pixel + 0.5 - start) / scale, half, extent, count);
            begin_[pixel + 1] = shares_.size();
        }
    }

    float covered(std::uint32_t pixel) const { return covered_[pixel]; }
    std::uint32_t first(std::uint32_t pixel) const { return first_[pixel]; }
    /// Of the image's pixels from the first on; they add up to 1. None where nothing is covered.
    std::span<const float> of(std::uint32_t pixel) const {
        return std::span(shares_).subspan(begin_[pixel], begin_[pixel + 1] - begin_[pixel]);
    }

  private:
    void add(std::uint32_t pixel, double middle, double half, double extent, std::uint32_t count) {
        const double from = std::clamp(middle - half, 0.0, extent),
                     to = std::clamp(middle + half, from, extent);
        const auto first = std::min(static_cast<std::uint32_t>(from), count - 1);
        first_[pixel] = first;
        for (std::uint32_t i = first; i < count && (i == first || i < to); ++i) {
            const double share = std::min<double>(i + 1.0, to) - std::max<double>(i, from);
            shares_.push_back(to > from ? static_cast<float>(std::max(share, 0.0) / (to - from)) : 1.0F);
        }
    }

    std::vector<std::size_t> begin_;  // of each pixel's shares, and the end
    std::vector<std::uint32_t> first_;
    std::vector<float> covered_;
    std::vector<float> shares_;
};

class ImageFragments : public FragmentMaker {
  public:
    ImageFragments(std::shared_ptr<const storage::ColorImage> image, const FramePlan& plan, double scale,
                   const Layer& layer)
        : image_(std::move(image)),
          width_(plan.width),
          height_(plan.height),
          across_(plan.width, image_->columns, image_->width, scale),
          down_(plan.height, image_->rows, image_->height, scale),
          opacity_(static_cast<float>(layer.opacity)),
          clips_(layer.clips()) {}

    void make(const PixelRect& pixels, Fragments& fragments) const override {
        std::uint32_t left = pixels.left, right = pixels.right;
        while (left < right && !(across_.covered(left) > 0.0F)) ++left;
        while (left < right && !(across_.covered(right - 1) > 0.0F)) --right;
        if (left == right) return;
        std::vector<glm::vec3> sums;
        for (auto row = pixels.top; row < pixels.bottom; ++row) {
            if (!(down_.covered(row) > 0.0F)) continue;
            addRows(row, left, right, sums);
            for (auto column = left; column < right; ++column) addPixel(column, row, left, sums, fragments);
        }
    }

  private:
    /// The means of the image's rows that a row of the picture sees, for all columns that it needs.
    void addRows(std::uint32_t row, std::uint32_t left, std::uint32_t right,
                 std::vector<glm::vec3>& sums) const {
        const std::size_t first = across_.first(left);
        const std::size_t end = across_.first(right - 1) + across_.of(right - 1).size();
        sums.assign(end - first, glm::vec3(0.0F));
        std::size_t y = down_.first(row);
        for (const float share : down_.of(row)) {
            const glm::vec3* const from = &image_->at(first, y++);
            for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += share * from[i];
        }
    }
    void addPixel(std::uint32_t column, std::uint32_t row, std::uint32_t left,
                  const std::vector<glm::vec3>& sums, Fragments& fragments) const {
        const float opacity = opacity_ * across_.covered(column) * down_.covered(row);
        if (!(opacity > 0.0F) || !stays(column, row)) return;
        glm::vec3 color(0.0F);
        std::size_t x = across_.first(column) - across_.first(left);
        for (const float share : across_.of(column)) color += share * sums[x++];
        fragments.push_back(
            {.column = column, .row = row, .depth = behindAll, .opacity = opacity, .color = color});
    }

    /// Whether nothing cuts off the middle of a pixel.
    bool stays(std::uint32_t column, std::uint32_t row) const {
        return clips_.empty() || inAll(clips_, placeInPicture(column + 0.5, row + 0.5, width_, height_));
    }

    std::shared_ptr<const storage::ColorImage> image_;
    std::uint32_t width_, height_;
    SideShares across_, down_;
    float opacity_;
    HalfSpaces clips_;
};

}  // namespace

void lowerImage(const Layer& layer, std::shared_ptr<const storage::ColorImage> image, Lowering& out) {
    const double scale = std::min(out.plan.width / image->columns, out.plan.height / image->rows);
    // It needs no slabs, but a depth at which they would begin.
    out.addDots(1.0, 1.0);
    out.plan.surfaces.push_back(
        std::make_shared<const ImageFragments>(std::move(image), out.plan, scale, layer));
}

}  // namespace mote::render
