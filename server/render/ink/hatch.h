// SPDX-License-Identifier: GPL-3.0-or-later
//
// Hatching (the dissertation's section 2.3.6, with strokes that follow the form: Hertzmann and Zorin 2000,
// Illustrating Smooth Surfaces): lines of even distance along one direction of a field (Jobard and Lefer
// 1997, Creating Evenly-Spaced Streamlines of Arbitrary Density), the more of them the darker it is to be,
// then along the other one, and again between those. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <stop_token>
#include <vector>

#include "server/render/ink/raster.h"

namespace mote::render {

/// Where hatches may go (hatch_field.h).
struct HatchField {
    struct Cell {
        /// Directions on the screen, unit, of first and second strokes; zero where nothing is seen.
        glm::vec2 first{0.0F}, second{0.0F};
        bool right = false, below = false;  ///< whether one surface goes on there
    };

    std::uint32_t pixels = 4;  ///< sides of a cell
    Raster<Cell> cells;        ///< that cover the picture
};

struct HatchOptions {
    double spacing = 4.0;  ///< between the strokes of a full layer, pixels
    double width = 1.0;    ///< of a stroke, pixels

    /// Of a stroke, pixels.
    double shortest() const { return 2.5 * spacing; }
};

/// Strokes that are drawn where it is to be dark enough.
struct HatchPass {
    bool second;     ///< whether they go in the second direction
    double spacing;  ///< pixels
    /// Densities of ink that are wanted (tone_grid.h): where the first of them is drawn, and where all are.
    double from, to;
    double reached;  ///< density of all strokes up to these
};

/// One after another, the darker the later.
std::vector<HatchPass> hatchPasses(const HatchOptions& options);

struct HatchStroke {
    std::vector<glm::dvec2> points;  ///< pixels; at least two
    std::uint32_t pass = 0;          ///< number of its pass
    bool second = false;             ///< whether it goes in the second direction
};

/// What is to be hatched.
struct HatchScene {
    const HatchField& field;
    const Raster<float>& density;  ///< of ink that is wanted; 0 where nothing may be hatched
    /// Whether a stroke may go from one of two pixels beside each other to the other: not across a step.
    std::function<bool(std::uint32_t column, std::uint32_t row, std::uint32_t otherColumn,
                       std::uint32_t otherRow)>
        goesOn;
};

/// In the order of passes. `before`: strokes that stay where they still go with all else.
std::vector<HatchStroke> hatch(const HatchScene& scene, const std::vector<HatchStroke>& before,
                               const HatchOptions& options, const std::stop_token& stop);

}  // namespace mote::render
