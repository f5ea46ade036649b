// SPDX-License-Identifier: GPL-3.0-or-later
//
// Dots of a real hierarchy on a surface that turns: those that stay hardly ever jump.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>

#include "preprocess/stipple/surface/surface_job.h"
#include "preprocess/stipple/surface/surface_thinning.h"
#include "server/render/layers/stipple/surface_dots.h"
#include "tests/support/view_text.h"
#include "tests/unit/particles/quiet_progress.h"
#include "tests/unit/surface/test_surfaces.h"

namespace mote::test {
namespace {

render::StippleSurface stippledTorus(const TestSurface& torus, std::uint32_t points) {
    QuietProgress progress;
    auto start = prep::evenSurfacePoints(*torus.walk, points, 1, 0.3, progress);
    EXPECT_TRUE(start.ok());
    const auto made = prep::thinSurface(*torus.walk, *std::move(start), {}, 0.3, progress);
    EXPECT_TRUE(made.ok());
    const Bounds bounds{{-1.4, -1.4, -1.4}, {1.4, 1.4, 1.4}};
    return {render::StippleReplay(*made), render::SurfaceRays(torus.mesh->positions, torus.mesh->triangles),
            bounds, torus.walk->area()};
}

struct Place {
    glm::vec3 position;  ///< on the surface
    double spacing;      ///< of neighbours at the wanted density
};

std::map<std::uint32_t, Place> placesAt(const render::StippleSurface& surface, double degrees) {
    const double angle = degrees * std::numbers::pi / 180.0;
    View view = viewOf(
        "{'width': 400, 'height': 400, 'camera': {'eye': [0, 0, 4], 'target': [0, 0, 0], "
        "'orthographicHeight': 3}, 'layers': [{'stipple': {'spacingPixels': 7}}]}");
    view.camera.eye = {4.0 * std::sin(angle), 2.0, 4.0 * std::cos(angle)};
    const auto& style = *view.layers[0].stipple();
    const render::SurfaceDots layer(surface, style, view, glm::dmat4(1.0));
    const render::SurfaceView screen(view, glm::dmat4(1.0));
    const render::WantedDensity wanted(surface, style, screen);
    std::map<std::uint32_t, Place> places;
    for (const auto& shown : layer.seen(layer.chosen())) {
        const double share = std::min<double>(wanted.at(shown.point).share, 1.0);
        const double spacing = std::sqrt(2.0 / (std::numbers::sqrt3 * share * surface.density()));
        places.emplace(shown.point, Place{shown.position, spacing});
    }
    return places;
}

TEST(TurnedSurface, DotsThatStaySeldomMoveFurtherThanTheJitterAllows) {
    const TestSurface torus(test::torus());
    const auto surface = stippledTorus(torus, 12000);
    std::size_t stayed = 0, beyond = 0, dots = 0;
    auto before = placesAt(surface, 0.0);
    for (int degrees = 1; degrees <= 30; ++degrees) {
        auto now = placesAt(surface, degrees);
        for (const auto& [point, place] : now) {
            const auto found = before.find(point);
            if (found == before.end()) continue;
            ++stayed;
            // Full jitter moves a dot by half of the distance of neighbours.
            const double way = glm::distance(place.position, found->second.position) / place.spacing;
            if (way > 0.5) ++beyond;
        }
        dots += now.size();
        before = std::move(now);
    }
    // Where a neighbour that went early comes back, all moves after its removal are undone at once: on the
    // teapot one dot in 4000.
    EXPECT_LE(beyond, stayed / 1000);
    EXPECT_GT(static_cast<double>(stayed), 0.9 * static_cast<double>(dots));
}

}  // namespace
}  // namespace mote::test
