// SPDX-License-Identifier: GPL-3.0-or-later
//
// ViewDrawer: draws scenes with one of the devices, or with ranks of the cpu device. One owner, one thread.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "server/render/device.h"
#include "server/render/layers/scene.h"
#include "tests/support/image.h"

namespace mote::test {

class ViewDrawer {
  public:
    virtual ~ViewDrawer() = default;
    /// Throws DeviceError, StorageError; std::logic_error where the picture is not the one that was asked
    /// for.
    virtual render::Picture draw(const render::Scene& scene, const render::Quality& quality,
                                 render::PixelFormat format = render::PixelFormat::srgb8) = 0;
};

/// "cpu", "egl", "ranks".
const std::vector<std::string>& drawerKinds();

/// `threads`: of the cpu device; 0: as many as there are. Throws DeviceError, std::invalid_argument.
std::unique_ptr<ViewDrawer> drawerOf(const std::string& kind, unsigned threads = 0);

Image imageOf(render::Picture picture);

}  // namespace mote::test
