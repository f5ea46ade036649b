// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/link/bench_pictures.h"

#include <cmath>
#include <tuple>

#include "server/render/device.h"
#include "server/render/layers/make_frame_plan.h"
#include "tests/bench/bench_step.h"

namespace mote::bench {
namespace {

constexpr double degree = 3.14159265358979323846 / 180.0;

View viewOf(std::uint32_t width, std::uint32_t height) {
    View view;
    view.width = width;
    view.height = height;
    view.camera = fitCamera({glm::dvec3(-0.6), glm::dvec3(0.6)}, view.aspect());
    view.layers.push_back({"bench/beam", 0, glm::dmat4(1.0), proto::ParticlesStyle()});
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
    const std::tuple<const char*, Curve, Curve> shown[] = {
        {"points", Curve::constant(0.0), Curve::constant(1.0)},
        {"volume", volume, Curve::constant(0.0)},
        {"both", volume, linkedFraction(volume)},
    };
    std::vector<Orbit> made;
    for (const auto& [name, opacity, fraction] : shown) {
        Orbit orbit{name, {}};
        render::Scene scene{viewOf(width, height), {{.step = step}}};
        scene.layers[0].particles =
            ParticlesStyle{opacity, ColorMap::standard(), fraction, 0.5, 1.0, glm::dvec3(1.0, 0.7, 0.3)};
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
