// SPDX-License-Identifier: GPL-3.0-or-later
//
// DepthSpans: for each small tile of a picture, between which depths anything of some boxes lies. Rays
// through the tile need not look elsewhere. A value; grows on one thread, then any number may ask.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

namespace mote::render {

/// Depths, in world units; nothing if `near` is greater.
struct DepthSpan {
    double near = std::numeric_limits<double>::infinity(), far = -near;

    void add(const DepthSpan& other) {
        near = std::min(near, other.near);
        far = std::max(far, other.far);
    }
};

class DepthSpans {
  public:
    /// How places in eye space come to a picture.
    struct View {
        glm::dvec2 size;   ///< of the picture, pixels
        double pixels;     ///< a unit of the window
        bool perspective;  ///< the window lies at depth 1
        double nearest;    ///< depth: what is nearer is not seen
    };

    explicit DepthSpans(const View& view);

    /// A box, by its corners in eye space.
    void add(const std::array<glm::dvec3, 8>& corners);
    /// The same of all that another one has of the same view.
    void add(const DepthSpans& other);
    /// Of the tile that (x, y) of the picture lies in, in pixels from its upper left corner.
    const DepthSpan& at(double x, double y) const {
        return spans_[tileOf(y, rows_) * columns_ + tileOf(x, columns_)];
    }

  private:
    static constexpr double edge = 8.0;  // pixels

    static std::size_t tileOf(double pixel, std::size_t tiles) {
        return static_cast<std::size_t>(std::clamp(pixel / edge, 0.0, static_cast<double>(tiles) - 1.0));
    }

    View view_;
    std::size_t columns_, rows_;
    std::vector<DepthSpan> spans_;
};

}  // namespace mote::render
