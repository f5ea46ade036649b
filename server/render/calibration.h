// SPDX-License-Identifier: GPL-3.0-or-later
//
// Calibration measures what points and pixels cost on a device, on a small plot of its own before the first
// view comes. It runs on the device's thread and takes some ten milliseconds on the processor, more on a
// software rasteriser.
#pragma once

#include "server/render/device.h"

namespace mote::render {

/// Pixel work of a quality relative to an exact picture's: samples along the ray, and slabs to composite.
double pixelWork(const Quality& quality);

/// Measures the device. Throws DeviceError.
DeviceCosts calibrate(Device& device);

}  // namespace mote::render
