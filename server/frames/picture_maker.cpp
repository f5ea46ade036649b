// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/frames/picture_maker.h"

#include <algorithm>
#include <new>
#include <utility>

#include "server/frames/layer_place.h"
#include "server/log.h"
#include "server/render/plan/frame_plan.h"
#include "storage/storage_error.h"

namespace mote::server {
namespace {

using render::Quality;

// A device that fails twice in a row (a driver was reset, its memory is lost) is made anew. Not after the
// first time: one picture may simply be too large for it.
constexpr int failuresBeforeNewDevice = 2;

void check(const render::Scene& scene) {
    for (const auto& step : scene.steps) {
        if (step != nullptr) step->check();
    }
}

std::vector<const render::HybridStep*> hybridsOf(const render::Scene& scene) {
    std::vector<const render::HybridStep*> hybrids;
    for (const auto& step : scene.hybrids) hybrids.push_back(step.get());
    return hybrids;
}

/// How many points an exact picture draws depends on the view, and the latest picture of the same data tells
/// it best: views of one hand follow each other closely. It is taken with care (a view that saw nothing is
/// followed by one that does), and of new data all points are expected.
ViewLoad loadOf(const render::Scene& scene, const PictureHistory& history) {
    ViewLoad load{.pixels = static_cast<double>(scene.view.width) * scene.view.height};
    for (const auto& step : scene.steps) {
        if (step == nullptr) continue;
        const auto thresholds = step->preview(0).threshold;
        const double share = thresholds.empty() ? 0.0 : thresholds.back();
        load.previewShare = load.points == 0.0 ? share : std::min(load.previewShare, share);
        load.points += static_cast<double>(step->pointCount());
    }
    if (scene.steps == history.steps && hybridsOf(scene) == history.hybrids)
        load.points = std::max(history.exactPoints, 0.01 * load.points);
    return load;
}

/// Dots of a moving view are placed and weighed; at rest they are made to fit.
render::PhotographEffort effortOf(Stage stage) {
    return stage == Stage::exact ? render::finePhotograph : render::quickPhotograph;
}

/// Beside those that are there.
void addDots(render::Scene& scene, const render::Dots& dots) {
    auto all = scene.dots ? std::make_shared<render::Dots>(*scene.dots) : std::make_shared<render::Dots>();
    all->insert(all->end(), dots.begin(), dots.end());
    scene.dots = std::move(all);
}

Quality qualityOf(Stage stage, const ViewLoad& load, QualityController& controller) {
    if (stage == Stage::quick) return controller.quick(load);
    return stage == Stage::intermediate ? controller.intermediate(load) : Quality::exact();
}

/// Of the exact picture's points; of layers with a share each, the least.
double shareOf(const render::FramePlan& plan, const Quality& quality) {
    double share = quality.pointFraction;
    for (const auto& layer : plan.layers) share = std::min(share, layer.share);
    return share;
}

void describe(MadePicture& made, const RenderJob& job, const std::string& device) {
    auto& message = made.message;
    message.set_view_id(job.task->viewId);
    message.set_asked_ns(job.task->askedNs);
    message.set_width(made.picture.width);
    message.set_height(made.picture.height);
    message.set_final(job.stage == Stage::exact);
    message.set_points_drawn(made.picture.pointsDrawn);
    message.set_device(device);
}

void learn(PictureHistory& history, const render::Scene& scene, const render::Picture& picture,
           const Quality& quality, double share, double ms) {
    const auto points = static_cast<double>(picture.pointsDrawn);
    history.quality.learn(static_cast<double>(picture.width) * picture.height, points, quality, ms);
    history.steps = scene.steps;
    history.hybrids = hybridsOf(scene);
    history.exactPoints = points / share;
}

Stage stageAfter(Stage stage, const render::Scene& scene, const PictureHistory& history) {
    if (stage == Stage::exact) return Stage::done;
    if (stage == Stage::intermediate) return Stage::exact;
    if (!history.dots.settled()) return Stage::quick;  // soft dots come to rest first
    return history.quality.worthIntermediate(loadOf(scene, history)) ? Stage::intermediate : Stage::exact;
}

}  // namespace

PictureMaker::PictureMaker(DeviceFactory factory, StepSource& steps, std::optional<render::DeviceCosts> costs)
    : factory_(std::move(factory)),
      steps_(steps),
      photographs_(steps),
      device_(factory_()),
      name_(device_->name()),
      costs_(costs ? *costs : device_->costs()) {}

void PictureMaker::trim() {
    if (device_) device_->trim();
}

Result<Making> PictureMaker::make(const RenderJob& job, PictureHistory& history) {
    const auto begun = Clock::now();
    try {
        if (!device_) device_ = factory_();
        history.quality.startFrom(costs_);
        steps_.beginPicture();
        Making made;
        const auto scene = makeScene(job, history, made);
        if (!scene.ok()) return scene.error();
        if (*scene) made = draw(job, **scene, begun, history);
        failures_ = 0;
        return made;
    } catch (const BrokenInvariant&) {
        throw;
    } catch (const storage::StorageError& failure) {
        return failure.error();
    } catch (const render::DeviceError& failure) {
        deviceFailed();
        return Error{ErrorCode::internal, "device", failure.what()};
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::resourceExhausted, "view", "there is not enough memory to draw it"};
    } catch (const std::exception& failure) {
        return Error{ErrorCode::internal, "view", failure.what()};
    }
}

void PictureMaker::deviceFailed() {
    if (++failures_ < failuresBeforeNewDevice) return;
    log::warn("the device failed {} times in a row and is made anew", failures_);
    failures_ = 0;
    device_.reset();
}

/// A view in motion is drawn from the volume alone where the rest is not there.
Status PictureMaker::addHybrid(render::Scene& scene, const Layer& layer, const RenderJob& job, Making& why) {
    if (!device_->abilities().hybrids) {
        return Error{ErrorCode::unsupported, "hybrid",
                     "the server's device, " + name_ + ", draws no hybrid volumes; --device cpu does"};
    }
    auto step = steps_.hybrid(layer.dataset, layer.step, layer.hybrid()->representation);
    if (step.ok() && !*step && job.stage != Stage::exact)
        step = steps_.hybridVolume(layer.dataset, layer.step, job.task->moving);
    if (!step.ok()) return step.error();
    why.waits = why.waits || !*step;
    scene.hybrids.back() = *std::move(step);
    return success();
}

/// Adds what a layer draws: a step, or dots; nothing of one that stipples what others drew, nor where `why`
/// says that the picture waits.
Status PictureMaker::addLayer(render::Scene& scene, const Layer& layer, const RenderJob& job,
                              DotHistory::Layer& history, Making& why) {
    scene.steps.emplace_back();
    scene.hybrids.emplace_back();
    if (layer.hybrid() != nullptr) {
        history = {};
        return addHybrid(scene, layer, job, why);
    }
    const auto* const style = layer.stipple();
    if (style != nullptr && style->onPlane()) {
        history = {};
        if (style->image.empty()) return success();
        const auto dots = photographs_.dots(scene.view, layer, effortOf(job.stage));
        if (!dots.ok()) return dots.error();
        addDots(scene, **dots);
        return success();
    }
    if (style != nullptr) {
        const auto dots = surfaceDots(scene.view, layer, steps_, job.stage == Stage::quick, history);
        if (!dots.ok()) return dots.error();
        addDots(scene, *dots);
        return success();
    }
    history = {};
    auto step = steps_.step(layer.dataset, layer.step);
    if (!step.ok()) return step.error();
    scene.steps.back() = *std::move(step);
    ParticlesStyle& points = *scene.view.layers[scene.steps.size() - 1].particles();
    if (points.opacityByPlot) points.pointOpacity = defaultPointOpacity(scene.steps.back()->pointCount());
    return success();
}

/// Not complete where `why` says that the picture waits.
Result<render::Scene> PictureMaker::sceneOf(const View& view, const RenderJob& job, DotHistory& history,
                                            Making& why) {
    render::Scene scene{view, {}};
    history.layers.resize(view.layers.size());
    for (std::size_t i = 0; i < view.layers.size(); ++i) {
        const auto added = addLayer(scene, view.layers[i], job, history.layers[i], why);
        if (!added.ok()) return inLayer(i, added.error());
    }
    return scene;
}

/// Draws a scene, and makes dots in its tones (figure 10 of the dissertation). Null where there is no picture
/// of it: `why` says so.
Result<std::shared_ptr<const render::Dots>> PictureMaker::stippled(const render::Scene& scene,
                                                                   const Layer& layer, const RenderJob& job,
                                                                   PictureHistory& history, Making& why) {
    const std::shared_ptr<const render::Dots> none;
    MOTE_RETURN_IF_ERROR(PhotographCache::checkDots(scene.view, *layer.stipple()));
    const auto tiles = photographs_.tiles(layer.dataset);
    if (!tiles.ok()) return tiles.error();
    const auto quality = qualityOf(job.stage, loadOf(scene, history), history.quality);
    const auto plan = planFor(job.stage, scene, quality);
    why.waits = !plan;
    if (!plan) return none;
    const auto begun = Clock::now();
    const auto picture = device_->render(*plan, render::PixelFormat::srgb8, job.stop);
    check(scene);
    want(*plan);
    if (!picture) return none;
    learn(history, scene, *picture, quality, shareOf(*plan, quality), milliseconds(Clock::now() - begun));
    return std::make_shared<const render::Dots>(
        render::photographDots(**tiles, render::luminanceOf(*picture), scene.view.width, scene.view.height,
                               *layer.stipple(), effortOf(job.stage)));
}

/// Nothing where `why` says that there will be no picture now.
Result<std::optional<render::Scene>> PictureMaker::makeScene(const RenderJob& job, PictureHistory& history,
                                                             Making& why) {
    View view = job.task->view;
    MOTE_RETURN_IF_ERROR(fitLayers(view, steps_));
    const auto stipples = [](const Layer& layer) { return layer.stipple() && layer.stipple()->sourceLayers; };
    const auto found = std::find_if(view.layers.begin(), view.layers.end(), stipples);
    if (found == view.layers.end()) {
        auto scene = sceneOf(view, job, history.dots, why);
        if (!scene.ok()) return scene.error();
        if (why.waits) return std::optional<render::Scene>();
        return std::optional(*std::move(scene));
    }
    const auto index = static_cast<std::size_t>(found - view.layers.begin());
    if (std::any_of(found + 1, view.layers.end(), stipples)) {
        return inLayer(index, {ErrorCode::unsupported, "stipple.source",
                               "only one layer of a view can stipple what the others drew"});
    }
    View before = view;
    View after = view;
    before.layers.erase(before.layers.begin() + static_cast<std::ptrdiff_t>(index), before.layers.end());
    after.layers.erase(after.layers.begin(), after.layers.begin() + static_cast<std::ptrdiff_t>(index) + 1);
    const auto drawn = sceneOf(before, job, history.dots, why);
    if (!drawn.ok()) return drawn.error();
    if (why.waits) return std::optional<render::Scene>();
    const auto dots = stippled(*drawn, *found, job, history, why);
    if (!dots.ok()) return inLayer(index, dots.error());
    if (!*dots) return std::optional<render::Scene>();
    DotHistory atOnce;  // what lies in front of a drawing does not fade in
    auto scene = sceneOf(after, job, atOnce, why);
    if (!scene.ok()) return scene.error();
    if (why.waits) return std::optional<render::Scene>();
    addDots(*scene, **dots);
    return std::optional(*std::move(scene));
}

/// Says what the pictures need; whether some of it is on its way.
bool PictureMaker::want(const render::FramePlan& plan) {
    bool coming = false;
    for (const auto& layer : plan.layers) coming = steps_.want(*layer.step, layer.need) || coming;
    return coming;
}

/// Nothing where the picture waits for data.
std::optional<render::FramePlan> PictureMaker::planFor(Stage stage, const render::Scene& scene,
                                                       const Quality& quality) {
    const auto plan = [&](render::Reading reading) {
        return render::makeFramePlan(scene, quality, selections_, device_->abilities(), reading);
    };
    auto now = plan(render::Reading::notForPoints);
    if (stage != Stage::exact || !now.waits()) return now;
    check(scene);
    if (want(now)) return std::nullopt;
    return plan(render::Reading::all);
}

Making PictureMaker::draw(const RenderJob& job, const render::Scene& scene, Clock::time_point begun,
                          PictureHistory& history) {
    const auto quality = qualityOf(job.stage, loadOf(scene, history), history.quality);
    auto plan = planFor(job.stage, scene, quality);
    if (!plan) return {.waits = true};
    // On a page they stay shapes.
    const auto dots = job.task->page ? std::exchange(plan->dots, nullptr) : nullptr;
    const auto planned = Clock::now();
    const auto format = job.stage == Stage::exact ? job.task->format : render::PixelFormat::srgb8;
    auto picture = device_->render(*plan, format, job.stop);
    check(scene);
    // Not before: what is read for this picture goes first.
    want(*plan);
    if (!picture) return {};
    const double renderMs = milliseconds(Clock::now() - planned);
    const double share = shareOf(*plan, quality);
    if (!scene.view.layers.empty()) learn(history, scene, *picture, quality, share, renderMs);
    MadePicture made{*std::move(picture),
                     {},
                     stageAfter(job.stage, scene, history),
                     dots,
                     plan->layers.empty() && plan->hybrids.empty()};
    describe(made, job, name_);
    made.message.set_point_fraction(share);
    const auto& shown = dots ? dots : plan->dots;
    if (shown) made.message.set_points_drawn(made.message.points_drawn() + shown->size());
    made.message.set_queued_ms(milliseconds(begun - job.task->arrived));
    made.message.set_plan_ms(milliseconds(planned - begun));
    made.message.set_render_ms(renderMs);
    return {.picture = std::move(made)};
}

}  // namespace mote::server
