// SPDX-License-Identifier: GPL-3.0-or-later
//
// A picture in motion, of fewer points and pixels, has the light of the exact one, whatever the particles
// (docs/PICTURE.md, "What a device may do").
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/gtc/packing.hpp>
#include <random>

#include "protocol/scene/plot_density.h"
#include "tests/golden/device_pictures.h"
#include "tests/reference/scene_styles.h"
#include "tests/support/beams.h"
#include "tests/support/view_text.h"

namespace mote::test {
namespace {

using render::Quality;

constexpr std::size_t count = 150'000;

/// Fields of particles as tests/truth/data.py makes them: thin, spread over orders of density, of unlike
/// weights.
std::vector<WeightedPoint> sheet() {
    std::mt19937_64 random(31);
    std::uniform_real_distribution<double> even(0.05, 0.95);
    std::normal_distribution<double> off(0.0, 1e-3);
    std::vector<WeightedPoint> points;
    for (std::size_t i = 0; i < count; ++i) {
        const double x = even(random), y = even(random);
        points.push_back({{x, y, 0.25 + 0.2 * x + 0.3 * y + off(random)}, 1.0});
    }
    return points;
}

std::vector<WeightedPoint> halo() {
    std::mt19937_64 random(32);
    std::normal_distribution<double> way(0.0, 1.0);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    std::vector<WeightedPoint> points;
    while (points.size() < count) {
        const double radius = 0.004 * std::pow(share(random), -1.0 / 1.5);
        const glm::dvec3 to(way(random), way(random), way(random));
        const glm::dvec3 place =
            glm::dvec3(0.5) + to * (radius / std::sqrt(to.x * to.x + to.y * to.y + to.z * to.z));
        if (std::max({std::abs(place.x - 0.5), std::abs(place.y - 0.5), std::abs(place.z - 0.5)}) < 0.5)
            points.push_back({place, 1.0});
    }
    return points;
}

/// One side weighs a hundredfold of the other.
std::vector<WeightedPoint> halves() {
    auto points = evenCloud(count, 33);
    for (auto& point : points) point.weight = point.position.x < 0.5 ? 1.0 : 100.0;
    return points;
}

std::vector<WeightedPoint> anyWeights() {
    auto points = beam({.core = 90000, .halo = 40000, .filaments = 20000, .seed = 34});
    std::mt19937_64 random(35);
    std::uniform_real_distribution<double> power(-2.0, 2.0);
    for (auto& point : points) point.weight = std::pow(10.0, power(random));
    return points;
}

std::vector<WeightedPoint> plainBeam() {
    return beam({.core = 90000, .halo = 40000, .filaments = 20000, .seed = 36});
}

struct Case {
    const char* name;
    std::vector<WeightedPoint> (*points)();
    /// Of what fills the whole box evenly, the light of a point changes fivefold with its depth, and what it
    /// must hide in place of others is told where the camera looks.
    double most = 0.05;
};

render::Scene sceneOf(const Case& of) {
    const auto step = MemoryStep::make(of.points(), {.leafCapacity = 64, .maxLevel = 10, .volumeLevel = 6});
    render::Scene scene{
        viewOf("{'width': 640, 'height': 360, 'camera': {'eye': [1.4, 1.1, 2.6], 'target': [0, 0, 0]},"
               "'layers': [{'particles': {}}]}"),
        {{.step = step}}};
    const auto points = static_cast<double>(step->pointCount());
    resolveByPlot(particlesIn(scene),
                  {step->logDensity(), step->pointCount(), step->nodes().density[0] / points});
    return scene;
}

class MotionLight : public testing::TestWithParam<std::tuple<std::string, Case>> {
  protected:
    /// Mean of linear red, green and blue.
    double light(const render::Scene& scene, const Quality& quality) {
        const auto plan = render::makeFramePlan(scene, quality, selections_, device_->abilities(),
                                                render::Reading::notForPoints);
        const auto picture = device_->render(plan, render::PixelFormat::linearHalf, std::stop_token());
        std::vector<std::uint16_t> halves(picture->pixels.size() / 2);
        std::memcpy(halves.data(), picture->pixels.data(), 2 * halves.size());
        double sum = 0.0;
        for (std::size_t i = 0; i < halves.size(); ++i)
            if (i % 4 != 3) sum += static_cast<double>(glm::unpackHalf1x16(halves[i]));
        return sum / (0.75 * static_cast<double>(halves.size()));
    }

    std::unique_ptr<render::Device> device_ = deviceOf(std::get<0>(GetParam()));
    render::SelectionCache selections_;
};

TEST_P(MotionLight, IsThatOfTheExactPicture) {
    const auto scene = sceneOf(std::get<1>(GetParam()));
    const double exact = light(scene, Quality::exact());
    ASSERT_GT(exact, 1e-3);
    double worst = 0.0;
    for (const double resolution : {1.0, 0.5, 1.0 / 3.0}) {
        for (const double fraction : {1.0, 0.5, 0.25, 0.1}) {
            const Quality quick{
                .resolutionScale = resolution, .pointFraction = fraction, .slabs = 24, .samplesPerCell = 1.0};
            const double off = light(scene, quick) / exact - 1.0;
            EXPECT_NEAR(off, 0.0, std::get<1>(GetParam()).most)
                << "resolution " << resolution << ", fraction " << fraction;
            worst = std::max(worst, std::abs(off));
        }
    }
    RecordProperty("worst", std::to_string(worst));
}

INSTANTIATE_TEST_SUITE_P(
    All, MotionLight,
    testing::Combine(testing::ValuesIn(deviceKinds()),
                     testing::Values(Case{"sheet", sheet}, Case{"halo", halo}, Case{"halves", halves, 0.1},
                                     Case{"anyWeights", anyWeights}, Case{"beam", plainBeam})),
    [](const auto& both) { return std::get<0>(both.param) + '_' + std::get<1>(both.param).name; });

}  // namespace
}  // namespace mote::test
