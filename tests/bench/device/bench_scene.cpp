// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/device/bench_scene.h"

#include <charconv>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <optional>

#include "protocol/scene/plot_density.h"
#include "storage/manifest.h"
#include "tests/bench/bench_step.h"
#include "tests/support/memory_step.h"

namespace mote::bench {
namespace {

using StepPointer = std::shared_ptr<const storage::ParticleStep>;

/// How much nearer "filling" is.
constexpr double nearer = 0.36;

/// A smooth ball with fine detail. Its t are whole 255ths, so that a program that reads bytes sees the same.
StepPointer ballOf(std::uint8_t level) {
    const LogDensity scale{1.0, std::exp(10.0)};
    const std::uint32_t size = 1U << level;
    std::vector<float> density;
    density.reserve(std::size_t{size} * size * size);
    const auto place = [size](std::uint32_t i) { return (2.0 * i + 1.0) / size - 1.0; };
    for (std::uint32_t k = 0; k < size; ++k) {
        for (std::uint32_t j = 0; j < size; ++j) {
            for (std::uint32_t i = 0; i < size; ++i) {
                const double x = place(i), y = place(j), z = place(k);
                const double detail = 0.75 + 0.25 * std::sin(20.0 * x) * std::cos(20.0 * y) +
                                      0.15 * std::sin(90.0 * x) * std::sin(80.0 * y) * std::sin(70.0 * z);
                const double value = std::clamp(std::exp(-6.0 * (x * x + y * y + z * z)) * detail, 0.0, 1.0);
                density.push_back(static_cast<float>(std::exp(10.0 * std::floor(255.0 * value) / 255.0)));
            }
        }
    }
    return test::MemoryStep::make({}, {.volumeLevel = level, .logDensity = scale, .volume = density});
}

/// A step, and what its default picture follows from.
struct BenchData {
    StepPointer step;
    PlotDensity plot;
};

BenchData madeHere(StepPointer step) {
    const PlotDensity plot{.scale = step->logDensity(), .particles = step->pointCount()};
    return {std::move(step), plot};
}

Result<BenchData> readStep(const std::string& folder) {
    MOTE_ASSIGN_OR_RETURN(const auto manifest, storage::readManifest(folder));
    MOTE_ASSIGN_OR_RETURN(auto step, storage::ParticleStep::open(folder, manifest, 0));
    return BenchData{std::move(step), PlotDensity::of(manifest.particles())};
}

/// The number behind "KIND:", where the text begins so.
std::optional<std::uint64_t> numberAfter(const std::string& text, std::string_view kind) {
    if (!text.starts_with(kind)) return std::nullopt;
    std::uint64_t number = 0;
    const char* const end = text.data() + text.size();
    const auto read = std::from_chars(text.data() + kind.size(), end, number);
    return read.ec == std::errc{} && read.ptr == end ? std::optional(number) : std::nullopt;
}

Result<BenchData> dataOf(const std::string& data) {
    if (const auto points = numberAfter(data, "beam:"); points && *points > 0 && *points <= 200'000'000)
        return madeHere(std::make_shared<const BenchStep>(*points, 7, 1));
    if (const auto level = numberAfter(data, "ball:"); level && *level >= 4 && *level <= 9)
        return madeHere(ballOf(static_cast<std::uint8_t>(*level)));
    return readStep(data);
}

/// About the opacity that ParaView gives a volume of bytes unasked.
Curve ballOpacity() {
    return Curve::create({{0.0, 0.0}, {0.25, 0.49}, {0.5, 0.8}, {1.0, ParticlesStyle::opacityLimit}}).value();
}

ParticlesStyle styleOf(const SceneOptions& options, const PlotDensity& plot) {
    if (options.shown == Shown::unsaid) {
        auto unsaid = particlesStyleOf(parseParticlesStyle({}).value());
        resolveByPlot(unsaid, plot);
        return unsaid;
    }
    ParticlesStyle style{Curve::constant(0.0),
                         ColorMap::standard(),
                         Curve::constant(options.shown == Shown::volume ? 0.0 : 1.0),
                         options.opacity,
                         options.pointSize,
                         glm::dvec3(1.0, 0.7, 0.3)};
    if (options.shown == Shown::volume) style.volumeOpacity = ballOpacity();
    if (options.shown == Shown::hybrid) style.volumeOpacity = Curve::create({{0.3, 0.0}, {1.0, 0.3}}).value();
    return style;
}

/// Any value for any point.
std::shared_ptr<const render::PointValues> someValues(std::uint64_t points) {
    auto values = std::make_shared<render::PointValues>();
    values->codes.resize(points);
    std::uint32_t number = 1;
    for (auto& code : values->codes) {
        number = number * 1664525U + 1013904223U;
        code = static_cast<render::ValueCode>(std::min<std::uint32_t>(number >> 16, render::greatestValue));
    }
    return values;
}

}  // namespace

Result<render::Scene> makeScene(const SceneOptions& options) {
    MOTE_ASSIGN_OR_RETURN(auto data, dataOf(options.data));
    View view;
    view.width = options.width;
    view.height = options.height;
    view.camera = fitCamera({glm::dvec3(-1.0), glm::dvec3(1.0)}, view.aspect());
    if (options.filling) view.camera.eye = glm::mix(view.camera.target, view.camera.eye, nearer);
    view.layers.push_back({"bench/data", 0, glm::dmat4(1.0), proto::ParticlesStyle()});
    render::Scene scene{std::move(view)};
    auto& drawn = scene.layers.emplace_back();
    drawn.step = std::move(data.step);
    drawn.particles = styleOf(options, data.plot);
    if (options.colorBy.empty()) return scene;
    const bool nearest = options.colorBy == "nearest";
    proto::ColorBy colorBy;
    colorBy.set_column("value");
    colorBy.set_of_pixel(nearest ? "nearest" : "mean");
    MOTE_ASSIGN_OR_RETURN(scene.view.layers[0].colorBy, parseColorBy(colorBy));
    drawn.values = someValues(drawn.step->pointCount());
    return scene;
}

std::vector<glm::dvec3> orbitOf(const Camera& camera, int count) {
    std::vector<glm::dvec3> eyes;
    for (int i = 0; i < count; ++i) {
        const glm::dmat4 turn = glm::rotate(glm::dmat4(1.0), glm::radians(10.0 * i), camera.up);
        eyes.push_back(camera.target + glm::dvec3(turn * glm::dvec4(camera.eye - camera.target, 0.0)));
    }
    return eyes;
}

}  // namespace mote::bench
