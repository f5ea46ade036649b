// SPDX-License-Identifier: GPL-3.0-or-later
//
// The reference renderer: docs/PICTURE.md in double precision and plain loops, slow and exact, for tests
// only. It shares no code that draws with the devices; what it takes from elsewhere is part of the definition
// of the picture: camera, styles, transfer functions, log density, drawnPoints, and the corrected samples of
// a hybrid volume (GridField). A pure function that uses all cores.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "server/render/layers/scene.h"
#include "server/render/plan/stroke.h"
#include "tests/support/image.h"

namespace mote::reference {

/// Where a point of a layer's step is drawn that has it at `place`: layer space.
using PlaceOf = std::function<glm::dvec3(std::uint32_t layer, std::uint64_t point, const glm::dvec3& place)>;

struct Options {
    double samplesPerCell = 16.0;  ///< volume samples along a ray, the edge of the finest volume's cell
    std::vector<std::shared_ptr<const render::Strokes>> strokes =
        {};                ///< besides the scene's layers; not null
    PlaceOf placeOf = {};  ///< empty: there. Highlights are of the whole step then
};

struct Picture {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<glm::dvec3> linear;  ///< linear RGB, row 0 on top
    /// 1 where a point of at most one pixel lies so close to the pixel's border that single precision may put
    /// it on the other side: such a pixel may rightly differ.
    std::vector<std::uint8_t> ambiguous;

    const glm::dvec3& at(std::uint32_t column, std::uint32_t row) const {
        return linear[std::size_t{row} * width + column];
    }
};

/// Throws storage::StorageError where the step's bytes are damaged.
Picture render(const render::Scene& scene, const Options& options = {});

/// sRGB-encoded, rounded to the nearest of 256 steps, alpha 255.
test::Image encode(const Picture& picture);

}  // namespace mote::reference
