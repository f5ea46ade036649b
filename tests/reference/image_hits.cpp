// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/reference/image_hits.h"

#include <algorithm>
#include <limits>

namespace mote::reference {
namespace {

/// What two intervals have in common.
double common(double fromA, double toA, double fromB, double toB) {
    return std::max(0.0, std::min(toA, toB) - std::max(fromA, fromB));
}

}  // namespace

ImageHits::ImageHits(const View& view, const Layer& layer, const storage::ColorImage& image)
    : image_(image),
      width_(view.width),
      height_(view.height),
      opacity_(layer.opacity),
      clips_(layer.clips()),
      scale_(std::min(view.width / image.columns, view.height / image.rows)),
      left_((view.width - scale_ * image.columns) / 2.0),
      top_((view.height - scale_ * image.rows) / 2.0) {}

/// The mean over a square around a place of the image, as far as it lies in it.
glm::dvec3 ImageHits::meanAround(double x, double y) const {
    const double side = std::max(1.0 / scale_, 1.0);
    glm::dvec3 sum(0.0);
    double area = 0.0;
    const auto first = [](double at) { return static_cast<std::uint32_t>(std::max(0.0, at)); };
    for (auto row = first(y - side); row < image_.height && row < y + side; ++row) {
        const double down = common(row, std::min(row + 1.0, image_.rows), y - 0.5 * side, y + 0.5 * side);
        for (auto column = first(x - side); column < image_.width && column < x + side; ++column) {
            const double across =
                common(column, std::min(column + 1.0, image_.columns), x - 0.5 * side, x + 0.5 * side);
            sum += across * down * glm::dvec3(image_.at(column, row));
            area += across * down;
        }
    }
    return area > 0.0 ? sum / area : sum;
}

void ImageHits::addRow(std::uint32_t row, std::vector<Hit>& hits) const {
    const double down = common(row, row + 1.0, top_, top_ + scale_ * image_.rows);
    for (std::uint32_t column = 0; column < width_; ++column) {
        const double covered = down * common(column, column + 1.0, left_, left_ + scale_ * image_.columns);
        // The pixel's middle, the picture's longer side from -1 to 1.
        const double unit = 2.0 / std::max(width_, height_);
        const glm::dvec3 place((column + 0.5 - width_ / 2.0) * unit, (height_ / 2.0 - row - 0.5) * unit, 0.0);
        if (!(covered * opacity_ > 0.0) || !inAll(clips_, place)) continue;
        hits.push_back({column, std::numeric_limits<double>::infinity(), covered * opacity_,
                        meanAround((column + 0.5 - left_) / scale_, (row + 0.5 - top_) / scale_)});
    }
}

}  // namespace mote::reference
