// SPDX-License-Identifier: GPL-3.0-or-later
//
// HatchField: where hatches may go, in cells of a picture: along the surface's principal directions where it
// bends more one way than the other (Hertzmann and Zorin 2000, Illustrating Smooth Surfaces), and elsewhere
// along the mean direction of the region. A value; made by many threads.
//
// ContinuousSight: tells whether two pixels see one smooth surface. Refers to what is seen; any number of
// threads.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <stop_token>
#include <vector>

#include "server/render/ink/hatch.h"
#include "server/render/ink/ink_memory.h"
#include "server/render/ink/modalities.h"
#include "server/render/ink/segments.h"

namespace mote::render {

class ContinuousSight {
  public:
    /// Refers to both.
    ContinuousSight(const Modalities& modalities, const InkCamera& camera)
        : modalities_(modalities), camera_(camera) {}

    /// Whether a surface goes on between two pixels near each other without a step or a crease.
    bool operator()(std::uint32_t column, std::uint32_t row, std::uint32_t otherColumn,
                    std::uint32_t otherRow) const;

    /// A place of a surface, eye space.
    struct Place {
        glm::dvec3 at{0.0};
        glm::dvec3 normal{0.0};  ///< towards the eye, unit; or zero where nothing is seen
        std::uint32_t part = Modalities::nothing;

        bool isSeen() const { return part != Modalities::nothing; }
    };
    Place placeOf(std::uint32_t column, std::uint32_t row) const;
    bool goesOn(const Place& one, const Place& other) const;
    /// Whether two pixels are so alike that nothing more need be asked.
    bool alike(std::size_t one, std::size_t other) const;

  private:
    const Modalities& modalities_;
    const InkCamera& camera_;
};

struct FieldOptions {
    std::uint32_t pixels = 4;  ///< sides of a cell
    /// Pixels over which a surface is looked at: what bends less along them is flat.
    double length = 90.0;
};

/// `regions`: of the picture, for their mean directions. `before`: strokes that were there before, which
/// count where the surface is flat.
HatchField hatchField(const Modalities& modalities, const InkCamera& camera, const Segments& regions,
                      const std::vector<HatchStroke>& before, const FieldOptions& options,
                      const std::stop_token& stop);

}  // namespace mote::render
