// SPDX-License-Identifier: GPL-3.0-or-later
//
// FieldSight: a hybrid volume of which the surface of one value is shown, or the greatest value behind each
// pixel (docs/PICTURE.md, "Hybrid volumes", "Shows"): rays through the pixels make its fragments where they
// are drawn. Holds its field; immutable, any number of threads.
#pragma once

#include <glm/mat4x4.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "protocol/scene/view.h"
#include "server/render/layers/hybrid/field_light.h"
#include "server/render/layers/hybrid/field_pieces.h"
#include "server/render/layers/lowering.h"
#include "server/render/layers/pixel_fragments.h"
#include "server/render/plan/field_blocks.h"
#include "server/render/plan/grid/volume_samples.h"

namespace mote::render {

class FieldSight {
  public:
    FieldSight(const Layer& layer, const HybridStyle& style, std::shared_ptr<const GridField> field,
               const Lowering& out);

    /// Appends the fragments of a row of pixels.
    void addRow(std::uint32_t row, Fragments& fragments) const;

  private:
    /// A ray between two depths, by the depth; `entered`: the side of what stays through which it comes in,
    /// none where it begins in it.
    struct Way {
        DepthLine line;  // in cells
        double enter = 0.0, leave = -1.0;
        const HalfSpace* entered = nullptr;
    };
    struct Found {
        double depth = 0.0, code = -1.0;
    };

    Way wayThrough(double x, double y) const;
    /// Whether a block of cells may have such a code.
    bool mayReach(std::size_t block, double code) const;
    /// Where a code is first met, or more, up to a depth.
    std::optional<double> first(const Way& way, double code, double leave) const;
    /// The greatest code, and where it is first met.
    Found greatest(const Way& way) const;
    /// Of the surface, with its light.
    glm::dvec3 colorAt(const Way& way, double depth) const;
    void addSurface(std::uint32_t column, std::uint32_t row, PixelFragments& pixel) const;
    void addGreatest(std::uint32_t column, std::uint32_t row, Fragments& fragments) const;

    std::shared_ptr<const GridField> field_;
    VolumeSamples samples_;
    FieldPieces pieces_;
    BlockRanges ranges_;
    TransferFunction transfer_;
    bool surface_;
    double isoCode_;
    glm::dvec3 color_;  // of the surface, linear RGB
    FieldLight light_;
    double opacity_, gap_;  // of the layer; of fragments, in depth
    bool exact_, perspective_;
    double nearest_;
    glm::dvec2 size_;  // of the picture, pixels
    double pixels_;    // a unit of the window
    glm::dmat4 eyeToCells_;
    glm::dmat3 slopeToNormal_;  // slopes of codes in cells to eye space, towards what is less
    HalfSpaces sides_;          // in cells: of the box, and clips
};

/// Adds what a layer shows to `out`.
void lowerSight(const Layer& layer, const HybridStyle& style, const std::shared_ptr<const GridField>& field,
                Lowering& out);

}  // namespace mote::render
