// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "server/render/device.h"

namespace mote::render {
namespace {

TEST(DeviceKind, IsKnownByName) {
    EXPECT_EQ(parseDeviceKind("auto").value(), DeviceKind::automatic);
    EXPECT_EQ(parseDeviceKind("egl").value(), DeviceKind::egl);
    EXPECT_EQ(parseDeviceKind("cpu").value(), DeviceKind::cpu);
    EXPECT_EQ(parseDeviceKind("").error().code, ErrorCode::invalidArgument);
    const auto unknown = parseDeviceKind("gpu");
    EXPECT_EQ(unknown.error().code, ErrorCode::invalidArgument);
    EXPECT_NE(unknown.error().message.find("gpu"), std::string::npos);
}

TEST(DeviceKind, GivesADevice) {
    EXPECT_EQ(createDevice(DeviceKind::egl)->name().substr(0, 5), "egl (");
    EXPECT_EQ(createDevice(DeviceKind::cpu)->name().substr(0, 5), "cpu (");
    // A software rasteriser is slower than our own device.
    const bool gpu = createDevice(DeviceKind::egl)->name().find("llvmpipe") == std::string::npos;
    EXPECT_EQ(createDevice(DeviceKind::automatic)->name().substr(0, 5), gpu ? "egl (" : "cpu (");
}

}  // namespace
}  // namespace mote::render
