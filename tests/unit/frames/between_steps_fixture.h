// SPDX-License-Identifier: GPL-3.0-or-later
//
// What tests of views between steps share: runs in memory, their pictures on a device, the light in these. Of
// one thread.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/gtc/packing.hpp>
#include <numeric>

#include "protocol/scene/srgb.h"
#include "server/frames/picture_maker.h"
#include "server/render/device.h"
#include "tests/reference/between_steps.h"
#include "tests/support/view_text.h"
#include "tests/unit/frames/memory_source.h"

namespace mote::server {

using test::MemoryStep, test::WeightedPoint;
using Points = std::vector<WeightedPoint>;

constexpr std::uint32_t width = 96, height = 72;

inline glm::dvec3 inBox(const glm::dvec3& place) {
    return glm::clamp(place, glm::dvec3(0.0), glm::dvec3(1.0 - 1e-9));
}

/// Linear light.
using Light = std::vector<glm::dvec3>;

inline Light lightOf(const render::Picture& picture) {
    Light light(std::size_t{picture.width} * picture.height);
    const bool half = picture.format == render::PixelFormat::linearHalf;
    for (std::size_t i = 0; i < light.size(); ++i) {
        for (int c = 0; c < 3; ++c) {
            const std::size_t at = 4 * i + static_cast<std::size_t>(c);
            std::uint16_t bits = 0;
            if (half) std::memcpy(&bits, picture.pixels.data() + 2 * at, 2);
            light[i][c] = half ? glm::unpackHalf1x16(bits) : srgbToLinear(picture.pixels[at] / 255.0);
        }
    }
    return light;
}

inline double total(const Light& light) {
    return std::accumulate(light.begin(), light.end(), 0.0,
                           [](double sum, const auto& pixel) { return sum + luminance(pixel); });
}

/// Of the brightest 8 x 8 pixels.
inline double brightestPatch(const Light& light) {
    constexpr std::uint32_t side = 8;
    std::vector<double> patches(std::size_t{width / side} * (height / side));
    for (std::uint32_t y = 0; y < height; ++y)
        for (std::uint32_t x = 0; x < width; ++x)
            patches[y / side * (width / side) + x / side] += luminance(light[std::size_t{y} * width + x]);
    return *std::max_element(patches.begin(), patches.end());
}

class BetweenSteps : public testing::TestWithParam<const char*> {
  protected:
    static View viewBetween(double share, const std::string& style = "{}") {
        View view = test::viewOf(
            "{'width': 96, 'height': 72, 'camera': {'eye': [0.8, 0.6, 4], 'target': [0, 0, 0]},"
            "'layers': [{'dataset': 'run', 'particles': " +
            style + "}]}");
        view.layers[0].towards = Towards{1, share};
        return view;
    }
    using Ids = std::vector<std::uint64_t>;
    /// `ids`: of the points of each step, as they come; none where the run has none.
    void addRun(const std::pair<Points, Points>& run, const std::string& name = "run",
                const std::optional<std::pair<Ids, Ids>>& ids = std::nullopt) {
        test::MemoryStepOptions options{.volumeLevel = 4};
        options.logDensity = MemoryStep::make(run.first, options)->logDensity();
        const MemorySource::Steps steps{MemoryStep::make(run.first, options),
                                        MemoryStep::make(run.second, options)};
        MemorySource::Columns columns;
        if (ids) columns = {idsBeside(*steps[0], ids->first), idsBeside(*steps[1], ids->second)};
        source_.add(name, steps, columns);
    }
    static std::shared_ptr<const test::MemoryColumns> idsBeside(const MemoryStep& step, const Ids& ids) {
        Ids byPoint;
        for (const auto row : step.rows(0, step.pointCount())) byPoint.push_back(ids[row]);
        return std::make_shared<const test::MemoryColumns>(
            step.pointCount(), std::vector<test::MemoryColumns::Column>(), std::move(byPoint));
    }
    Result<Making> make(const View& view, Stage stage = Stage::exact,
                        render::PixelFormat format = render::PixelFormat::srgb8) {
        auto task = std::make_shared<ViewTask>();
        task->view = view;
        task->format = format;
        return maker_.make({.session = 1, .task = task, .stage = stage}, history_);
    }
    render::Picture drawn(const View& view, Stage stage = Stage::exact,
                          render::PixelFormat format = render::PixelFormat::srgb8) {
        auto made = make(view, stage, format);
        EXPECT_TRUE(made.ok()) << made.error().toString();
        EXPECT_TRUE(made.ok() && made->picture);
        return made.ok() && made->picture ? made->picture->picture : render::Picture();
    }
    /// As the frames of a view give it.
    render::Scene sceneOf(const View& view) const {
        render::Scene scene{view, {}};
        for (std::size_t i = 0; i < view.layers.size(); ++i) {
            auto style = particlesStyleOf(*view.layers[i].particles(), view.height);
            resolveByPlot(style, source_.plot(view.layers[i].dataset));
            auto& data = scene.layers.emplace_back();
            data.particles = std::move(style);
            data.step = source_.steps(view.layers[i].dataset)[view.layers[i].step];
            if (view.layers[i].highlight) data.highlight = data.step;
        }
        return scene;
    }
    double psnr(const View& view, const render::Picture& picture,
                const reference::MovedPlace& moved = {}) const {
        const auto expected = reference::encode(reference::renderBetween(
            view, [this](const View& one) { return sceneOf(one); }, moved));
        double squares = 0.0;
        for (std::size_t i = 0; i < expected.pixels.size(); ++i)
            squares += std::pow(expected.pixels[i] - picture.pixels[i], 2);
        return 10.0 *
               std::log10(255.0 * 255.0 * static_cast<double>(expected.pixels.size()) / (squares + 1e-9));
    }

    MemorySource source_;
    PictureMaker maker_{[] {
                            const auto kind = render::parseDeviceKind(GetParam());
                            return render::createDevice(kind.value(), 1);
                        },
                        source_, render::DeviceCosts{}};
    PictureHistory history_{QualityController(30.0)};
};

inline const std::string withVolume =
    "{'volume': {'curve': [{'density': 0.3, 'opacity': 0}, {'density': 1, 'opacity': 0.3}]},"
    "'points': {'opacity': 0.7, 'sizePixels': 1.5}}";

}  // namespace mote::server
