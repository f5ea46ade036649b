// SPDX-License-Identifier: GPL-3.0-or-later
//
// A FieldPlan is a scalar field that absorbs and glows, as a device is to draw it: its samples, where its box
// lies, its transfer function, its light and where it is cut. A value that shares its samples; part of a
// FramePlan.
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <memory>
#include <variant>
#include <vector>

#include "protocol/scene/hybrid_style.h"
#include "protocol/scene/transfer_function.h"
#include "server/render/plan/grid_field.h"
#include "server/render/plan/point_values.h"
#include "server/render/plan/step_volume.h"
#include "storage/particles/particle_step.h"

namespace mote::render {

/// What light makes of a colour: its factor, and what is added to it in white; each 0 to 1.
struct Shade {
    float diffuse, specular;

    bool operator==(const Shade&) const = default;
};
/// Shades by a normal's code.
using Shades = std::array<Shade, 256>;

/// A step as a volume: cells with extinction and t at their centres, without normals. Its colour is that of
/// its t, or of the values that stand in its place, by the plan's transfer function.
struct DensityField {
    std::shared_ptr<const storage::ParticleStep> step;
    std::shared_ptr<const StepVolume> grid = {};     ///< not null, but before a rank has made its own
    double strength = 1.0;                           ///< times its extinction, 0 to 1
    std::shared_ptr<const PointValues> values = {};  ///< by leaf, that colour the grid; null: none
};

/// A field of samples with their normals.
struct CorrectedField {
    std::shared_ptr<const GridField> grid = {};
    bool bricks = true;       ///< whether they are drawn, where there are some
    double correction = 1.0;  ///< how much of theirs is applied, 0 to 1
    /// How much faster than evenly the weights of neighbouring samples of a brick change, half way between
    /// them.
    double steepness = 1.0;
    double gradient = 0.0;  ///< how much of its extinction goes with how steeply it changes, 0 to 1
    Shades shades = {};

    bool corrected() const { return bricks && grid->bricks && correction > 0.0; }
    /// Whether the coarse grid shows in bricks, too.
    bool mixed() const { return corrected() && correction < 1.0; }
};

struct FieldPlan {
    std::size_t layer;               ///< the one of the view that it is of
    glm::dmat4 boxToEye{1.0};        ///< the field's box [0, 1]^3 to eye space
    glm::dmat3 boxToLayer{2.0};      ///< without its place; a plot's box is [-1, 1]^3 in layer space
    TransferFunction transfer;       ///< by t, or in the source's unit
    std::vector<HalfSpace> clips{};  ///< in the box: what lies in all of them is drawn; of any length
    std::variant<DensityField, CorrectedField> samples;

    const DensityField* density() const { return std::get_if<DensityField>(&samples); }
    const CorrectedField* grid() const { return std::get_if<CorrectedField>(&samples); }
};

}  // namespace mote::render
