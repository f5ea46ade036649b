// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/views/view_drawer.h"

#include <fmt/format.h>

#include <cmath>

#include "server/render/cpu/cpu_device.h"
#include "server/render/layers/make_frame_plan.h"
#include "tests/support/rank_crew.h"

namespace mote::test {
namespace {

using render::Device;
using render::Picture;
using render::PixelFormat;
using render::Quality;

void checkShape(const Picture& picture, const render::FramePlan& plan, PixelFormat format) {
    const std::size_t bytes = std::size_t{plan.width} * plan.height * render::bytesPerPixel(format);
    const bool right = picture.width == plan.width && picture.height == plan.height &&
                       picture.format == format && picture.pixels.size() == bytes;
    if (right) return;
    throw std::logic_error(fmt::format("a picture of {} x {} and {} bytes in place of {} x {} and {}",
                                       picture.width, picture.height, picture.pixels.size(), plan.width,
                                       plan.height, bytes));
}

/// As a session plans: of what is not needed, nothing.
Picture drawWith(Device& device, const render::Scene& scene, const Quality& quality, PixelFormat format) {
    render::SelectionCache selections;
    const auto reading = quality == Quality::exact() ? render::Reading::all : render::Reading::notForPoints;
    const auto plan = makeFramePlan(scene, quality, selections, device.abilities(), reading);
    auto picture = device.render(plan, format, {});
    if (!picture) throw std::logic_error("no picture, though nobody stopped it");
    checkShape(*picture, plan, format);
    return *std::move(picture);
}

class DeviceDrawer final : public ViewDrawer {
  public:
    explicit DeviceDrawer(std::unique_ptr<Device> device) : device_(std::move(device)) {}
    Picture draw(const render::Scene& scene, const Quality& quality, PixelFormat format) override {
        return drawWith(*device_, scene, quality, format);
    }

  private:
    std::unique_ptr<Device> device_;
};

class RanksDrawer final : public ViewDrawer {
  public:
    Picture draw(const render::Scene& scene, const Quality& quality, PixelFormat format) override {
        constexpr int ranks = 3;
        RankCrew crew(ranks, scene);
        return drawWith(crew.device(), scene, quality, format);
    }
};

}  // namespace

const std::vector<std::string>& drawerKinds() {
    static const std::vector<std::string> kinds{"cpu", "egl", "ranks"};
    return kinds;
}

std::unique_ptr<ViewDrawer> drawerOf(const std::string& kind, unsigned threads) {
    if (kind == "ranks") return std::make_unique<RanksDrawer>();
    if (kind == "cpu")
        return std::make_unique<DeviceDrawer>(
            std::make_unique<render::CpuDevice>(render::CpuOptions{.threads = threads}));
    if (kind != "egl") throw std::invalid_argument("there are no devices but cpu, egl and ranks");
    return std::make_unique<DeviceDrawer>(render::createDevice(render::DeviceKind::egl));
}

Image imageOf(Picture picture) {
    return {picture.width, picture.height, std::move(picture.pixels)};
}

}  // namespace mote::test
