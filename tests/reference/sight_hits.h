// SPDX-License-Identifier: GPL-3.0-or-later
//
// SightHits: what a hybrid volume is in each pixel that shows a surface or its greatest values
// (docs/PICTURE.md, "Shows"): many samples along each ray. Made once for a picture; immutable, safe on any
// number of threads.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "tests/reference/hit.h"
#include "tests/reference/hybrid_field.h"

namespace mote::reference {

/// Whether a layer is a volume of which no matter is shown.
inline bool showsSight(const Layer& layer) {
    return layer.hybrid() != nullptr && !layer.hybrid()->shows().empty();
}

class SightHits {
  public:
    SightHits(const View& view, const Layer& layer, const render::GridField& step, double samplesPerCell);

    /// Appends the hits of a row of pixels, column by column, front to back.
    void addRow(std::uint32_t row, std::vector<Hit>& hits) const;

  private:
    struct Ray {
        glm::dvec3 origin, perDepth;  ///< layer space
        double enter, leave;
        std::optional<glm::dvec3> side;  ///< the normal of where it came in
    };
    struct Met {
        double depth;
        glm::dvec3 color;
    };

    Ray through(double x, double y) const;
    double step(const Ray& ray) const;
    double value(const Ray& ray, double depth) const {
        return field_->value(ray.origin + depth * ray.perDepth);
    }
    /// Where a value is greatest between two depths, if it rises and falls once there.
    double summit(const Ray& ray, double from, double to) const;
    /// Where a value is met between a depth with less and one with as much.
    double crossing(const Ray& ray, double below, double above, double least) const;
    /// The first depth, up to an end, with such a value at least.
    std::optional<double> first(const Ray& ray, double least, double end) const;
    std::optional<Met> surface(const Ray& ray) const;
    std::optional<Hit> greatest(std::uint32_t column, std::uint32_t row) const;

    const View& view_;
    Layer layer_;  // with points that are smooth
    HybridStyle style_;
    double samplesPerCell_;
    std::unique_ptr<const HybridField> field_;
    TransferFunction transfer_;
    double codeStep_;  // of values
    double isovalue_;
    glm::dmat4 layerToEye_;
    HalfSpaces within_;
};

}  // namespace mote::reference
