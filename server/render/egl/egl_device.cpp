// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/egl_device.h"

#include "protocol/scene/mote_check.h"
#include "server/render/blank_picture.h"
#include "server/render/calibration.h"
#include "server/render/color_finder.h"
#include "server/render/egl/egl_context.h"
#include "server/render/egl/frame_run.h"
#include "server/render/egl/gl_objects.h"
#include "server/render/egl/shader_library.h"

namespace mote::render {
namespace {

constexpr std::size_t mostLayers = 8;  // as in shaders/frame.glsl
static_assert(mostLayers >= View::maxLayers);

/// The layers as the shaders count them.
std::size_t layerCount(const FramePlan& plan) {
    return layerSlots(plan).size() + plan.fields.size() - plan.densities();
}

/// Mesa's software rasteriser compiles a program for the samplers' states that it finds, also for texel
/// buffers, which have none: they find what another program left there. So each program was compiled twice,
/// in the first frame and in the second. Once one program has read a volume in every place, all find the same
/// for good. `volume`: any that shaders may read.
void setSamplerStates(ShaderLibrary& shaders, const GlTexture& volume) {
    constexpr GLuint places = 16;  // that GL has at least; as many as any program reads
    const GlBuffer sums(sizeof(float));
    for (GLuint unit = 0; unit < places; ++unit) glBindTextureUnit(unit, volume.get());
    sums.bindStorage(0);
    glUseProgram(shaders.program("sampler_states", {}));
    glDispatchCompute(1, 1, 1);
}

}  // namespace

struct EglDevice::State {
    explicit State(EglOptions chosen)
        : options(std::move(chosen)),
          shaders(options.shaderDirectory),
          steps(options.residentBytes),
          residentGrids(options.residentBytes) {}

    EglOptions options;
    ShaderLibrary shaders;
    ResidentSteps steps;
    ResidentGrids residentGrids;
    DensityTables tables;
    FrameBuffers buffers;
    ColorFinder colors;
    StageTimes times;

    /// Before the first frame.
    void begin() {
        const float nothing = 0.0F;
        GlTexture noVolume = volumeTexture(1, &nothing);
        setSamplerStates(shaders, noVolume);
        buffers.noVolume = std::move(noVolume);
    }
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

DeviceCosts EglDevice::costs() {
    return calibrate(*this);
}

std::optional<Picture> EglDevice::render(const FramePlan& plan, PixelFormat format, std::stop_token stop) {
    MOTE_CHECK(plan.width > 0 && plan.height > 0 && layerCount(plan) <= mostLayers);
    MOTE_CHECK(plan.slabs <= mostSlabs);
    if (stop.stop_requested()) return std::nullopt;
    if (plan.blank()) return blankPicture(plan, format);
    const auto colors = state_->colors.find(plan, stop);
    if (!colors) return std::nullopt;
    const EglContext::Current current(context_);
    state_->shaders.reloadChanged();
    if (!state_->buffers.noVolume) state_->begin();
    FrameRun run(plan, *colors, format, state_->options, state_->shaders, state_->steps,
                 state_->residentGrids, state_->tables, state_->buffers, std::move(stop));
    auto picture = run.draw();
    state_->times = run.times();
    return picture;
}

void EglDevice::trim() {
    const EglContext::Current current(context_);
    state_->steps.dropExpired();
    state_->colors.dropExpired();
    state_->residentGrids.dropExpired();
}

const StageTimes& EglDevice::lastTimes() const {
    return state_->times;
}

}  // namespace mote::render
