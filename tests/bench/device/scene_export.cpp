// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/device/scene_export.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>

#include "protocol/scene/srgb.h"
#include "server/render/layers/particles/lower_particles.h"
#include "server/render/plan/octree_cell.h"

namespace mote::bench {
namespace {

constexpr int colors = 256;

std::string textOf(const glm::dvec3& v) {
    return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v.x, v.y, v.z);
}

std::string sceneText(const render::Scene& scene, const std::vector<glm::dvec3>& eyes) {
    const View& view = scene.view;
    const ParticlesStyle style = render::particlesStyleOf(scene, 0);
    std::vector<std::string> places, knots, table;
    for (const auto& eye : eyes) places.push_back(textOf(eye));
    for (const auto& knot : style.volumeOpacity.knots())
        knots.push_back(fmt::format("[{:.17g}, {:.17g}]", knot.x, knot.y));
    for (int i = 0; i < colors; ++i)
        table.push_back(textOf(linearToSrgb(style.colorMap(i / (colors - 1.0)))));
    return fmt::format(
        "{{\"width\": {}, \"height\": {}, \"fovYDegrees\": {:.17g}, \"target\": {}, \"up\": {},\n"
        "\"eyes\": [{}],\n\"cells\": {}, \"opacityLength\": {}, \"opacity\": [{}],\n"
        "\"pointColor\": {},\n\"colors\": [{}]}}\n",
        view.width, view.height, view.camera.fovYDegrees, textOf(view.camera.target), textOf(view.camera.up),
        fmt::join(places, ", "), scene.layers[0].step->volumeSize(), ParticlesStyle::opacityLength,
        fmt::join(knots, ", "), textOf(linearToSrgb(style.pointColor)), fmt::join(table, ", "));
}

void writePoints(const storage::ParticleStep& step, std::ostream& out) {
    const auto leaves = step.leaves();
    const auto nodes = step.nodes();
    std::vector<float> places;
    for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf) {
        const double edge = std::ldexp(1.0, -nodes.level[leaves.node[leaf]]);
        const glm::dvec3 corner = glm::dvec3(render::cellPlace(nodes.morton[leaves.node[leaf]])) * edge;
        places.clear();
        for (const auto& p : step.positions(leaves.pointBegin[leaf], leaves.pointCount[leaf])) {
            const glm::dvec3 inside = (glm::dvec3(p.x, p.y, p.z) + 0.5) / 65536.0;
            const glm::vec3 place(2.0 * (corner + edge * inside) - 1.0);
            places.insert(places.end(), {place.x, place.y, place.z});
        }
        out.write(reinterpret_cast<const char*>(places.data()),
                  static_cast<std::streamsize>(places.size() * sizeof(float)));
    }
}

void writeVolume(const storage::ParticleStep& step, std::ostream& out) {
    const auto scale = step.logDensity();
    for (const float density : step.volume()) {
        out.put(static_cast<char>(std::lround(255.0 * std::max(0.0, scale.ofCell(density)))));
    }
}

template <class Write>
Status writeTo(const std::filesystem::path& path, Write write) {
    std::ofstream out(path, std::ios::binary);
    write(out);
    out.close();
    if (!out) return Error{ErrorCode::internal, path.string(), "cannot be written"};
    return success();
}

}  // namespace

Status exportScene(const render::Scene& scene, const std::vector<glm::dvec3>& eyes,
                   const std::filesystem::path& folder) {
    const auto& step = *scene.layers[0].step;
    MOTE_RETURN_IF_ERROR(
        writeTo(folder / "scene.json", [&](std::ostream& out) { out << sceneText(scene, eyes); }));
    if (render::particlesStyleOf(scene, 0).volumeOpacity.maximum() > 0.0) {
        return writeTo(folder / "volume.u8", [&](std::ostream& out) { writeVolume(step, out); });
    }
    return writeTo(folder / "points.f32", [&](std::ostream& out) { writePoints(step, out); });
}

}  // namespace mote::bench
