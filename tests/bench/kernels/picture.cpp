// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/kernels/picture.h"

#include "server/render/cpu/cpu_device.h"

#include "server/render/layers/make_frame_plan.h"

namespace mote::bench {

render::Scene beamScene(Shown shown) {
    SceneOptions options;
    options.shown = shown;
    options.opacity = 0.25;
    return makeScene(options).value();
}

render::Picture pictureOf(Shown shown) {
    render::CpuDevice device;
    const auto plan = render::makeFramePlan(beamScene(shown), render::Quality::exact());
    return device.render(plan, render::PixelFormat::srgb8, {}).value();
}

}  // namespace mote::bench
