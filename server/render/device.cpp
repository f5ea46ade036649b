// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/device.h"

#include "server/render/egl/egl_device.h"

namespace mote::render {

Result<DeviceKind> parseDeviceKind(std::string_view name) {
    if (name == "auto") return DeviceKind::automatic;
    if (name == "egl") return DeviceKind::egl;
    if (name == "cpu") {
        return Error{ErrorCode::unsupported, "device",
                     "the device \"cpu\" does not exist yet; there are auto, egl"};
    }
    return Error{ErrorCode::invalidArgument, "device",
                 "no device is called \"" + std::string(name) + "\"; there are auto, egl"};
}

std::unique_ptr<Device> createDevice(DeviceKind kind) {
    if (kind == DeviceKind::cpu) throw DeviceError("the device \"cpu\" does not exist yet");
    return std::make_unique<EglDevice>();
}

}  // namespace mote::render
