// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/link/bench_pictures.h"

#include <cmath>

#include "server/render/device.h"
#include "server/render/layers/make_frame_plan.h"
#include "tests/bench/bench_step.h"

namespace mote::bench {
namespace {

constexpr double degree = 3.14159265358979323846 / 180.0;

View viewOf(std::uint32_t width, std::uint32_t height, const Curve& volume, const Curve& points) {
    View view;
    view.width = width;
    view.height = height;
    view.camera = fitCamera({glm::dvec3(-0.6), glm::dvec3(0.6)}, view.aspect());
    view.layers.push_back(
        {"bench/beam", 0, glm::dmat4(1.0),
         ParticlesStyle{volume, ColorMap::standard(), points, 0.5, 1.0, glm::dvec3(1.0, 0.7, 0.3)}});
    return view;
}

void turn(Camera& camera, double angle) {
    const glm::dvec3 arm = camera.eye - camera.target;
    const double c = std::cos(angle), s = std::sin(angle);
    camera.eye = camera.target + glm::dvec3(c * arm.x + s * arm.z, arm.y, c * arm.z - s * arm.x);
}

}  // namespace

std::vector<Orbit> orbits(std::uint32_t width, std::uint32_t height, int count) {
    const auto step = std::make_shared<const BenchStep>(1'000'000, 5, 1);
    const auto device = render::createDevice(render::DeviceKind::automatic);
    const Curve volume = Curve::create({{0.3, 0.0}, {1.0, 0.3}}).value();
    const std::pair<const char*, View> views[] = {
        {"points", viewOf(width, height, Curve::constant(0.0), Curve::constant(1.0))},
        {"volume", viewOf(width, height, volume, Curve::constant(0.0))},
        {"both", viewOf(width, height, volume, linkedFraction(volume))},
    };
    std::vector<Orbit> made;
    for (const auto& [name, view] : views) {
        Orbit orbit{name, {}};
        render::Scene scene{view, {step}};
        for (int i = 0; i < count; ++i) {
            const auto plan = render::makeFramePlan(scene, render::Quality::exact());
            orbit.pictures.push_back(*device->render(plan, render::PixelFormat::srgb8, {}));
            turn(scene.view.camera, degree);
        }
        made.push_back(std::move(orbit));
    }
    return made;
}

}  // namespace mote::bench
