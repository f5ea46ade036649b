// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/egl_device.h"

#include <utility>

#include "protocol/base/mote_check.h"
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

void check(const FramePlan& plan) {
    MOTE_CHECK(plan.width > 0 && plan.height > 0 && layerCount(plan) <= mostLayers);
    MOTE_CHECK(plan.slabs <= mostSlabs);
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
        const glm::vec2 nothing(0.0F);
        GlTexture noVolume = volumeTexture(glm::uvec3(1), &nothing);
        setSamplerStates(shaders, noVolume);
        buffers.noVolume = std::move(noVolume);
    }

    /// As FrameRun::draw().
    bool draw(const EglContext& context, const FramePlan& plan, const FrameColors& found, Picture& picture,
              std::uint32_t& next, bool patient, std::stop_token stop) {
        const EglContext::Current current(context);
        shaders.reloadChanged();
        if (!buffers.noVolume) begin();
        FrameRun run(plan, found, picture.format, options, shaders, steps, residentGrids, tables, buffers,
                     std::move(stop));
        const bool done = run.draw(picture, next, patient);
        times = run.times();
        return done;
    }
};

/// A picture between two of its bands.
class EglDevice::Unfinished final : public UnfinishedPicture {
  public:
    Unfinished(EglDevice& device, const FramePlan& plan, FrameColors colors, PixelFormat format)
        : device_(device), plan_(plan), colors_(std::move(colors)), picture_(newPicture(plan, format)) {}

    bool advance(const std::stop_token& pause) override { return draw(true, pause); }
    bool draw(bool patient, const std::stop_token& stop) {
        return device_.state_->draw(device_.context_, plan_, colors_, picture_, next_, patient, stop);
    }
    Picture take() override { return std::move(picture_); }
    std::uint64_t bytes() const override { return picture_.pixels.capacity(); }

  private:
    EglDevice& device_;
    const FramePlan& plan_;
    const FrameColors colors_;
    Picture picture_;
    std::uint32_t next_ = 0;  // row of tiles
};

EglDevice::EglDevice(EglOptions options) : state_(std::make_unique<State>(std::move(options))) {}

EglDevice::~EglDevice() {
    // GL objects can only be deleted in their context; if it is lost, so are they.
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
    check(plan);
    if (stop.stop_requested()) return std::nullopt;
    if (plan.blank()) return blankPicture(plan, format);
    auto colors = state_->colors.find(plan, stop);
    if (!colors) return std::nullopt;
    Unfinished picture(*this, plan, *std::move(colors), format);
    if (!picture.draw(false, stop)) return std::nullopt;
    return picture.take();
}

std::unique_ptr<UnfinishedPicture> EglDevice::begin(const FramePlan& plan, PixelFormat format,
                                                    std::stop_token stop) {
    check(plan);
    if (stop.stop_requested()) return nullptr;
    if (plan.blank()) return finishedPicture(blankPicture(plan, format));
    auto colors = state_->colors.find(plan, stop);
    if (!colors) return nullptr;
    return std::make_unique<Unfinished>(*this, plan, *std::move(colors), format);
}

void EglDevice::countTo(const std::shared_ptr<storage::BlockBudget>& budget) {
    state_->residentGrids.countTo(budget);
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
