// SPDX-License-Identifier: GPL-3.0-or-later
//
// PointHits: which points and dots touch which pixels, at what depth and opacity (docs/PICTURE.md, "Points",
// "Dots"). A value; made once for a picture.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "server/render/scene.h"

namespace mote::reference {

/// A point's footprint in one pixel.
struct Hit {
    std::uint32_t pixel;  ///< row * width + column
    std::uint32_t layer;  ///< or, after all layers, the dot
    double depth;         ///< world units along the line of sight
    double alpha;         ///< opacity of the point or dot times coverage, > 0
    glm::dvec3 color{};   ///< linear RGB
};

class PointHits {
  public:
    explicit PointHits(const render::Scene& scene);

    /// Front to back; equal depths by layer.
    std::span<const Hit> of(std::uint32_t pixel) const {
        return std::span(hits_).subspan(begin_[pixel], begin_[pixel + 1] - begin_[pixel]);
    }
    /// One a pixel: see Picture::ambiguous.
    const std::vector<std::uint8_t>& ambiguous() const { return ambiguous_; }

  private:
    void addLayer(const render::Scene& scene, std::uint32_t layer);
    void addDots(const render::Scene& scene);
    void addPoint(const View& view, std::uint32_t layer, const glm::dvec3& inEye);
    void addSquare(const View& view, Hit hit, double px, double py, double size);
    void addDisc(const View& view, Hit hit, double px, double py, double size);
    void markAmbiguous(const View& view, double px, double py);
    void sort(std::size_t pixels);

    std::vector<Hit> hits_;
    std::vector<std::size_t> begin_;  // of each pixel's hits, and the end
    std::vector<std::uint8_t> ambiguous_;
};

/// The nearest depth that is seen: nothing nearer, in points or volume. Minus infinity for an orthographic
/// camera.
double nearestDepth(const Camera& camera);

}  // namespace mote::reference
