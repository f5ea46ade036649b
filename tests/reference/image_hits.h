// SPDX-License-Identifier: GPL-3.0-or-later
//
// ImageHits: what an image layer is in each pixel (docs/PICTURE.md, "Images"): each pixel's square laid over
// the squares of the image's pixels, in double precision. Immutable, safe on any number of threads.
#pragma once

#include <cstdint>
#include <vector>

#include "protocol/scene/view.h"
#include "storage/image/image_file.h"
#include "tests/reference/hit.h"

namespace mote::reference {

class ImageHits {
  public:
    /// The image must outlive it.
    ImageHits(const View& view, const Layer& layer, const storage::ColorImage& image);

    /// Appends the hits of a row of pixels.
    void addRow(std::uint32_t row, std::vector<Hit>& hits) const;

  private:
    glm::dvec3 meanAround(double x, double y) const;

    const storage::ColorImage& image_;
    std::uint32_t width_, height_;
    double opacity_;
    HalfSpaces clips_;
    double scale_;       // pixels of the view, a pixel of the image
    double left_, top_;  // of the image in the view, pixels
};

}  // namespace mote::reference
