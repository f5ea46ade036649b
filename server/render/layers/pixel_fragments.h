// SPDX-License-Identifier: GPL-3.0-or-later
//
// What rays through a pixel meet of surfaces, of triangles or of one value of a field, becomes the pixel's
// fragments (docs/PICTURE.md, "Meshes").
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "server/render/plan/fragment.h"

namespace mote::render {

/// Makes what the samples of one pixel see of a surface its fragments. Each sample's light goes on behind
/// what it meets; a fragment hides as much of the pixel's light as the samples that meet it lose, so that all
/// of them together have the mean light of the samples. One owner; used again from pixel to pixel.
class PixelFragments {
  public:
    static constexpr std::uint32_t mostSamples = 8;
    /// Where a pixel is looked through at rest (docs/PICTURE.md), from its centre, in sixteenths of it; in
    /// motion it is looked through at its centre.
    static constexpr std::array<std::array<int, 2>, mostSamples> places{
        {{1, -3}, {-1, 3}, {5, 1}, {-3, -5}, {-5, 5}, {-7, -1}, {3, 7}, {7, -7}}};

    struct Hit {
        double depth;
        std::uint32_t sample;
        glm::dvec3 color;  ///< linear RGB
    };

    /// `opacity`: of each surface. `gap`: hits that lie closer together in depth are one fragment, unless a
    /// sample meets two of them.
    PixelFragments(std::uint32_t samples, double opacity, double gap)
        : samples_(samples), opacity_(opacity), gap_(gap) {}

    std::uint32_t samples() const { return samples_; }
    void add(const Hit& hit) { hits_.push_back(hit); }
    /// Appends the fragments of what was added, front to back, and forgets it.
    void take(std::uint32_t column, std::uint32_t row, Fragments& fragments);

  private:
    struct Group {
        double depth = 0.0, lost = 0.0;
        glm::dvec3 light{0.0};
    };

    std::uint32_t samples_;
    double opacity_, gap_;
    std::vector<Hit> hits_;
};

}  // namespace mote::render
