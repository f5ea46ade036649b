// SPDX-License-Identifier: GPL-3.0-or-later
//
// HybridField: the field of a hybrid volume and its light, anywhere in layer space (docs/PICTURE.md, "Hybrid
// volumes"). It shares its step's numbers, which must outlive it; safe on any number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "protocol/scene/view.h"
#include "server/render/layers/hybrid/lower_hybrid.h"
#include "server/render/plan/grid_field.h"
#include "tests/reference/volume.h"

namespace mote::reference {

/// What light makes of a normal: the factor of a colour, and the white that is added.
struct Shade {
    double diffuse = 0.0, specular = 0.0;
};

/// `normal`: eye space, unit; or zero, where there is none.
Shade shadeOf(const glm::dvec3& normal, const Light& light, const Camera& camera, double silhouettes);
/// `normal`: a code. `layerToEye`: of the layer.
Shade shadeOf(std::uint8_t normal, const Light& light, const glm::dmat4& layerToEye, const Camera& camera,
              double silhouettes = 0.0);

class HybridField final : public Volume {
  public:
    HybridField(const render::GridField& step, const Layer& layer, const Camera& camera);

    /// In the source's unit.
    double value(const glm::dvec3& inLayer) const;
    VolumeMatter at(const glm::dvec3& inLayer) const override;
    /// The direction in which the value falls fastest, by differences as far apart as samples lie; of any
    /// length.
    glm::dvec3 falling(const glm::dvec3& inLayer) const;
    std::vector<HalfSpace> within() const override;
    double cellEdge() const override;

  private:
    struct Sampled {
        double code = 0.0;
        Shade shade;
        double slope = 0.0;  ///< 0 to 1
    };
    /// docs/PICTURE.md, "Gradients": of each sample of the coarse grid, and of the bricks.
    void findSlopes();
    double smoothCode(const glm::uvec3& sample) const;
    double slopeOf(const glm::dvec3& perBox) const;
    Sampled sampled(const glm::dvec3& inLayer) const;
    Sampled sampledLow(const glm::dvec3& inBox) const;
    Sampled sampledBrick(std::int32_t number, const glm::dvec3& inBrick) const;
    template <class Index, class Weight>
    Sampled interpolated(const std::uint16_t* values, const std::uint8_t* normals, const double* slopes,
                         const glm::dvec3& place, const glm::uvec3& last, const Index& index,
                         const Weight& weightOf) const;

    const render::GridField& step_;
    HybridStyle style_;
    HybridRepresentation drawn_;
    bool corrected_;
    TransferFunction transfer_;
    glm::dmat4 layerToBox_;
    std::array<Shade, 256> shades_;
    double deviation_ = 0.0;                          // of the coarse grid's codes
    std::vector<double> coarseSlopes_, brickSlopes_;  // empty: nobody asks for them
};

}  // namespace mote::reference
