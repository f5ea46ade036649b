// SPDX-License-Identifier: GPL-3.0-or-later
//
// Calibration: what points and pixels cost on a device, measured on a small plot of its own before the first
// view comes. Called on the device's thread; takes some ten milliseconds on the processor, more on a software
// rasteriser.
#pragma once

#include "server/render/device.h"

namespace mote::render {

/// Pixel work of a quality relative to an exact picture's: samples along the ray, and slabs to composite.
double pixelWork(const Quality& quality);

/// Throws DeviceError.
DeviceCosts calibrate(Device& device);

}  // namespace mote::render
