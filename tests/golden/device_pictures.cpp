// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/golden/device_pictures.h"

#include <stdexcept>

#include "protocol/scene/srgb.h"

namespace mote::test {

std::vector<std::string> deviceKinds() {
    return {"egl", "cpu"};
}

std::unique_ptr<render::Device> deviceOf(const std::string& kind) {
    return render::createDevice(render::parseDeviceKind(kind).value());
}

Image picture(render::Device& device, const render::Scene& scene, const render::Quality& quality) {
    auto result =
        device.render(render::makeFramePlan(scene, quality), render::PixelFormat::srgb8, std::stop_token());
    if (!result) throw std::runtime_error("the device gave no picture, though nobody stopped it");
    if (result->format != render::PixelFormat::srgb8)
        throw std::runtime_error("the picture is not in 8-bit sRGB");
    return {result->width, result->height, std::move(result->pixels)};
}

double meanLight(const Image& image) {
    double sum = 0.0;
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        if (i % 4 != 3) sum += srgbToLinear(image.pixels[i] / 255.0);
    }
    return sum / (0.75 * static_cast<double>(image.pixels.size()));
}

}  // namespace mote::test
