// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/egl_device.h"

#include <glm/gtc/packing.hpp>

#include "protocol/scene/mote_check.h"
#include "protocol/scene/srgb.h"
#include "server/render/egl/egl_context.h"
#include "server/render/egl/frame_run.h"

namespace mote::render {
namespace {

constexpr std::uint32_t mostSlabs = 256;
constexpr std::size_t mostLayers = 8;   // as in shaders/frame.glsl

/// A picture of nothing but background.
Picture background(const FramePlan& plan, PixelFormat format) {
    Picture picture{.width = plan.width, .height = plan.height, .format = format, .pixels = {}};
    const std::size_t pixels = std::size_t{plan.width} * plan.height;
    const std::size_t size = bytesPerPixel(format);
    picture.pixels.resize(pixels * size);
    std::array<std::uint8_t, 8> pixel{};
    if (format == PixelFormat::linearHalf) {
        const std::uint64_t packed = glm::packHalf4x16(glm::vec4(plan.background, 1.0));
        for (std::size_t i = 0; i < 8; ++i) pixel[i] = static_cast<std::uint8_t>(packed >> (8 * i));
    } else {
        const glm::dvec3 encoded = glm::round(glm::clamp(linearToSrgb(plan.background), 0.0, 1.0) * 255.0);
        pixel = {static_cast<std::uint8_t>(encoded.x), static_cast<std::uint8_t>(encoded.y),
                 static_cast<std::uint8_t>(encoded.z), 255};
    }
    for (std::size_t i = 0; i < pixels; ++i) std::copy_n(pixel.begin(), size, picture.pixels.begin() + static_cast<std::ptrdiff_t>(i * size));
    return picture;
}

}   // namespace

struct EglDevice::State {
    explicit State(EglOptions chosen)
        : options(std::move(chosen)), shaders(options.shaderDirectory), steps(options.residentBytes) {}

    EglOptions options;
    ShaderLibrary shaders;
    ResidentSteps steps;
    TransferTextures transfers;
    FrameBuffers buffers;
    StageTimes times;
};

EglDevice::EglDevice(EglOptions options) : state_(std::make_unique<State>(std::move(options))) {}

EglDevice::~EglDevice() {
    // GL objects can only be deleted in their context; where it is lost, so are they.
    try {
        const EglContext::Current current(context_);
        state_.reset();
    } catch (const DeviceError&) {
        static_cast<void>(state_.release());
    }
}

std::string EglDevice::name() const {
    return "egl (" + context_.renderer() + ")";
}

std::optional<Picture> EglDevice::render(const FramePlan& plan, PixelFormat format, std::stop_token stop) {
    MOTE_CHECK(plan.width > 0 && plan.height > 0 && plan.layers.size() <= mostLayers);
    MOTE_CHECK(plan.slabs >= 1 && plan.slabs <= mostSlabs);
    if (stop.stop_requested()) return std::nullopt;
    if (plan.layers.empty() || !(plan.farDepth > plan.nearDepth)) return background(plan, format);
    const EglContext::Current current(context_);
    state_->shaders.reloadChanged();
    FrameRun run(plan, format, state_->options, state_->shaders, state_->steps, state_->transfers, state_->buffers,
                 std::move(stop));
    auto picture = run.draw();
    state_->times = run.times();
    return picture;
}

void EglDevice::trim() {
    const EglContext::Current current(context_);
    state_->steps.dropExpired();
}

const StageTimes& EglDevice::lastTimes() const {
    return state_->times;
}

}   // namespace mote::render
