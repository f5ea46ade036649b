// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/device.h"

#include <algorithm>
#include <array>
#include <utility>

#include "server/render/cpu/cpu_device.h"
#include "server/render/egl/egl_device.h"

namespace mote::render {
namespace {

/// Whether OpenGL is drawn by the processor, which our own device does better.
bool software(const Device& egl) {
    constexpr std::array<std::string_view, 3> rasterisers{"llvmpipe", "softpipe", "swrast"};
    const std::string name = egl.name();
    return std::any_of(rasterisers.begin(), rasterisers.end(),
                       [&](std::string_view one) { return name.find(one) != std::string::npos; });
}

std::unique_ptr<Device> bestDevice(unsigned threads) {
    try {
        auto egl = std::make_unique<EglDevice>();
        if (!software(*egl)) return egl;
    } catch (const DeviceError&) {
        // No OpenGL 4.5 here: the processor needs none.
    }
    return std::make_unique<CpuDevice>(CpuOptions{.threads = threads});
}

}  // namespace

std::unique_ptr<UnfinishedPicture> Device::begin(const FramePlan& plan, PixelFormat format,
                                                 std::stop_token stop) {
    auto picture = render(plan, format, std::move(stop));
    return picture ? finishedPicture(*std::move(picture)) : nullptr;
}

Result<DeviceKind> parseDeviceKind(std::string_view name) {
    if (name == "auto") return DeviceKind::automatic;
    if (name == "egl") return DeviceKind::egl;
    if (name == "cpu") return DeviceKind::cpu;
    return Error{ErrorCode::invalidArgument, "device",
                 "no device is called \"" + std::string(name) + "\"; there are auto, cpu, egl"};
}

std::unique_ptr<Device> createDevice(DeviceKind kind, unsigned threads) {
    if (kind == DeviceKind::automatic) return bestDevice(threads);
    if (kind == DeviceKind::cpu) return std::make_unique<CpuDevice>(CpuOptions{.threads = threads});
    return std::make_unique<EglDevice>();
}

}  // namespace mote::render
