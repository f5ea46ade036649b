// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/device.h"

#include "server/render/cpu/cpu_device.h"
#include "server/render/egl/egl_device.h"

namespace mote::render {
namespace {

std::unique_ptr<Device> bestDevice() {
    try {
        return std::make_unique<EglDevice>();
    } catch (const DeviceError&) {
        return std::make_unique<CpuDevice>();
    }
}

}  // namespace

Result<DeviceKind> parseDeviceKind(std::string_view name) {
    if (name == "auto") return DeviceKind::automatic;
    if (name == "egl") return DeviceKind::egl;
    if (name == "cpu") return DeviceKind::cpu;
    return Error{ErrorCode::invalidArgument, "device",
                 "no device is called \"" + std::string(name) + "\"; there are auto, cpu, egl"};
}

std::unique_ptr<Device> createDevice(DeviceKind kind) {
    if (kind == DeviceKind::automatic) return bestDevice();
    if (kind == DeviceKind::cpu) return std::make_unique<CpuDevice>();
    return std::make_unique<EglDevice>();
}

}  // namespace mote::render
