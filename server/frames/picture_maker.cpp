// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/frames/picture_maker.h"

#include <algorithm>
#include <new>
#include <optional>
#include <tuple>
#include <utility>

#include "protocol/scene/view_parts.h"
#include "server/figures/annotate.h"
#include "server/frames/dot_maker.h"
#include "server/frames/layer_kinds.h"
#include "server/frames/mean_picture.h"
#include "server/frames/picture_history.h"
#include "server/frames/planning.h"
#include "server/frames/scene_maker.h"
#include "server/frames/view_task.h"
#include "server/log.h"
#include "server/render/layers/make_frame_plan.h"
#include "storage/storage_error.h"

namespace mote::server {
namespace {

using render::FramePlan, render::PixelFormat, render::Quality;

/// Attempt: what a picture makes of its session's dots and ink, undone where it comes to nothing. It lives
/// while the picture is made.
///
/// A picture that is stopped or waits is made again. Where it is one of a row that shall always be the same,
/// it then finds what it found: ink that follows the picture before must not follow one that was not
/// finished.
class Attempt {
  public:
    Attempt(const ViewTask& task, DotHistory& history) : history_(history) {
        if (task.finalOnly) before_ = copyOf(history);
    }
    ~Attempt() {
        if (before_) history_ = *std::move(before_);
    }
    Attempt(const Attempt&) = delete;
    Attempt& operator=(const Attempt&) = delete;

    void succeeded() { before_.reset(); }
    /// What it made of the history is kept for when it goes on.
    void paused(Draft& draft) {
        if (before_) draft.after = std::move(history_);
    }

  private:
    DotHistory& history_;
    std::optional<DotHistory> before_;
};

std::vector<std::shared_ptr<const storage::ParticleStep>> stepsOf(const render::Scene& scene) {
    std::vector<std::shared_ptr<const storage::ParticleStep>> steps;
    for (const auto& layer : scene.layers) steps.push_back(layer.step);
    return steps;
}

std::vector<const render::GridField*> hybridsOf(const render::Scene& scene) {
    std::vector<const render::GridField*> hybrids;
    for (const auto& layer : scene.layers) hybrids.push_back(layer.hybrid.get());
    return hybrids;
}

/// How much there is to draw. How many points an exact picture draws depends on the view, and the latest
/// picture of the same data tells it best: views of one hand follow each other closely. It is taken with care
/// (a view that saw nothing is followed by one that does), and of new data all points are expected.
ViewLoad loadOf(const render::Scene& scene, const PictureHistory& history) {
    ViewLoad load{.pixels = static_cast<double>(scene.view.width) * scene.view.height};
    for (const auto& step : stepsOf(scene)) {
        if (step == nullptr) continue;
        const auto thresholds = step->preview(0).threshold;
        const double share = thresholds.empty() ? 0.0 : thresholds.back();
        load.previewShare = load.points == 0.0 ? share : std::min(load.previewShare, share);
        load.points += static_cast<double>(step->pointCount());
    }
    if (stepsOf(scene) == history.steps && hybridsOf(scene) == history.hybrids)
        load.points = std::max(history.exactPoints, 0.01 * load.points);
    return load;
}

/// What a picture tells of the next one. `share`: of the exact picture's points. `ms`: that it took, apart
/// from data.
void learn(PictureHistory& history, const render::Scene& scene, const render::Picture& picture,
           const render::Quality& quality, double share, double ms) {
    const auto points = static_cast<double>(picture.pointsDrawn);
    history.quality.learn(static_cast<double>(picture.width) * picture.height, points, quality, ms);
    history.steps = stepsOf(scene);
    history.hybrids = hybridsOf(scene);
    history.exactPoints = points / share;
}

/// What a frame says beside what it shows, in pixels of the scene's view; null where that asks for none.
std::shared_ptr<const Marks> annotationsOf(const render::Scene& scene, const render::FramePlan& plan,
                                           StepSource& data) {
    const View& view = scene.view;
    if (!view.annotations) return nullptr;
    std::vector<LayerFacts> layers(view.layers.size());
    for (std::size_t i = 0; i < layers.size(); ++i) {
        const Layer& layer = view.layers[i];
        if (i < view.shown.size()) layers[i].shown = view.shown[i];
        if (const auto found = data.dataset(layer.dataset); found.ok()) layers[i].manifest = found->manifest;
        const auto& [step, highlight] = std::tie(scene.layers[i].step, scene.layers[i].highlight);
        if (!layer.particles() || step == nullptr) continue;
        if (layer.select) layers[i].chosen = step->pointCount();
        if (layer.highlight && highlight) layers[i].highlighted = highlight->pointCount();
        if (layer.colorBy) layers[i].colorRange = colorRangeOf(*layer.colorBy);
    }
    for (const auto& field : plan.fields) {
        // Where a column colours the volume, the bar is the column's alone.
        const auto* const cells = field.density();
        if (cells == nullptr || cells->values == nullptr) layers[field.layer].transfer = field.transfer;
    }
    for (const auto& points : plan.points) {
        if (!points.colors) layers[points.layer].points = points.look.color;
    }
    return std::make_shared<const Marks>(annotate(view, layers));
}

// A device that fails twice in a row (a driver was reset, its memory is lost) is made anew. Not after the
// first time: one picture may simply be too large for it.
constexpr int failuresBeforeNewDevice = 2;

void check(const render::Scene& scene) {
    for (const auto& layer : scene.layers) {
        if (layer.step != nullptr) layer.step->check();
    }
}

Quality qualityOf(Stage stage, const ViewLoad& load, QualityController& controller) {
    if (stage == Stage::quick) return controller.quick(load);
    return stage == Stage::intermediate ? controller.intermediate(load) : Quality::exact();
}

/// The share of the exact picture's points that is drawn; the least, where layers have one each.
double shareOf(const FramePlan& plan, const Quality& quality) {
    double share = quality.pointFraction;
    for (const auto& points : plan.points) share = std::min(share, points.share);
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

Stage stageAfter(Stage stage, const render::Scene& scene, const PictureHistory& history) {
    if (stage == Stage::exact) return Stage::done;
    if (stage == Stage::intermediate) return Stage::exact;
    if (!history.dots.settled()) return Stage::quick;  // soft dots come to rest first
    return history.quality.worthIntermediate(loadOf(scene, history)) ? Stage::intermediate : Stage::exact;
}

/// Whether there is anything of any layer.
bool anything(const View& view) {
    return std::any_of(view.layers.begin(), view.layers.end(),
                       [](const Layer& layer) { return layer.opacity > 0.0; });
}

}  // namespace

PictureMaker::PictureMaker(DeviceFactory factory, StepSource& steps, std::optional<render::DeviceCosts> costs,
                           render::WorkInTurns::Duration leastTurn, std::shared_ptr<PictureMemory> memory)
    : factory_(std::move(factory)),
      steps_(steps),
      leastTurn_(leastTurn),
      memory_(std::move(memory)),
      device_(newDevice()),
      name_(device_->name()),
      costs_(costs ? *costs : device_->costs()) {}

std::unique_ptr<render::Device> PictureMaker::newDevice() const {
    auto device = factory_();
    if (memory_) device->countTo(memory_->data());
    return device;
}

void PictureMaker::trim() {
    if (device_) device_->trim();
}

Result<Making> PictureMaker::make(const RenderJob& job, PictureHistory& history) {
    try {
        return makeAny(job, history);
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

/// What the history keeps of another job goes.
Result<Making> PictureMaker::makeAny(const RenderJob& job, PictureHistory& history) {
    auto parts = viewParts(job.task->view);
    if (parts.size() == 1) {
        giveUpDrafts(std::exchange(history.mean, nullptr).get());
        return makeOne(job, history);
    }
    if (job.task->page && job.task->page->plotter) {
        return Error{ErrorCode::unsupported, "page.plotter",
                     "a pen draws one step, and the view shows two; say \"share\": 0 or 1 of \"towards\""};
    }
    drop(history.draft);
    // Those of the latest picture are its parts' now.
    history.steps.clear();
    history.hybrids.clear();
    if (history.mean == nullptr || !history.mean->isOf(job)) {
        const auto before = std::exchange(history.mean, nullptr);
        giveUpDrafts(before.get());
        history.mean = std::make_shared<MeanPicture>(job, std::move(parts), history, before.get());
    }
    const auto make = [this](const RenderJob& part, PictureHistory& its) { return makeOne(part, its); };
    return history.mean->goOn(job, history, make);
}

Result<Making> PictureMaker::makeOne(const RenderJob& job, PictureHistory& history) {
    if (!device_) device_ = newDevice();
    history.quality.startFrom(costs_);
    steps_.beginPicture();
    stop_ = job.stop;
    Making made;
    auto planning = planningOf(job, history);
    if (planning && !planning->planning->advance(job.pause)) {
        history.draft = std::move(planning);
        return made;
    }
    Attempt attempt(*job.task, history.dots);
    auto draft = draftOf(history);
    if (draft == nullptr) {
        MOTE_ASSIGN_OR_RETURN(
            draft, planning ? planning->planning->take(history, made) : newDraft(job, history, made));
    }
    planning.reset();
    if (draft == nullptr) {
        made.memory.leave();
        return made;
    }
    if (made.memory.bytes() > 0) draft->memory = std::move(made.memory);
    const bool done = draw(job, *draft, job.pause);
    failures_ = 0;
    if (done) {
        made.picture = finished(job, *draft, history);
        attempt.succeeded();
    } else if (draft->picture != nullptr || draft->sight != nullptr) {
        attempt.paused(*draft);
        history.draft = std::move(draft);
    }
    return made;
}

void PictureMaker::deviceFailed() {
    if (++failures_ < failuresBeforeNewDevice) return;
    log::warn("the device failed {} times in a row and is made anew", failures_);
    failures_ = 0;
    device_.reset();
}

/// Nothing where `why` says that the picture waits; here and below.
Result<std::optional<render::Scene>> PictureMaker::sceneOf(const View& view, const RenderJob& job,
                                                           DotHistory& dots, PictureHistory& history,
                                                           Making& why) {
    auto scene = makeScene(view, job, steps_, photographs_, dots, [&] { return admit(job, history, why); });
    if (scene.ok() && !*scene) why.waits = true;
    return scene;
}

/// Draws a scene, and makes dots in its tones (figure 10 of the dissertation). Nothing, too, where the
/// drawing was stopped.
Result<std::optional<render::Dots>> PictureMaker::stippled(const render::Scene& scene, const Layer& layer,
                                                           const RenderJob& job, PictureHistory& history,
                                                           Making& why) {
    const std::optional<render::Dots> none;
    MOTE_RETURN_IF_ERROR(checkDots(scene.view, *layer.stipple()));
    MOTE_ASSIGN_OR_RETURN(const auto tiles, planeOf(layer, steps_));
    const auto quality = qualityOf(job.stage, loadOf(scene, history), history.quality);
    const auto begun = workClock();
    const auto plan = planFor(job, scene, quality);
    why.waits = !plan || !tiles;
    if (why.waits) return none;
    const auto picture = drawnBefore(*plan, job);
    check(scene);
    want(*plan);
    if (!picture) return none;
    learn(history, scene, *picture, quality, shareOf(*plan, quality), milliseconds(workClock() - begun));
    return std::optional(render::photographDots(*tiles, render::luminanceOf(*picture), scene.view.width,
                                                scene.view.height, *layer.stipple(), effortOf(job.stage)));
}

/// A quick picture is drawn at once, since it is never paused. Null where it was stopped.
std::unique_ptr<render::UnfinishedPicture> PictureMaker::begin(const FramePlan& plan, PixelFormat format,
                                                               Stage stage, const std::stop_token& stop) {
    return stage == Stage::quick ? device_->Device::begin(plan, format, stop)
                                 : device_->begin(plan, format, stop);
}

/// Drawn by the thread that has the device, wherever the plan was made. Nothing where it was stopped.
std::optional<render::Picture> PictureMaker::drawnBefore(const FramePlan& plan, const RenderJob& job) {
    std::unique_ptr<render::UnfinishedPicture> begun;
    std::optional<render::Picture> picture;
    const auto draw = [&](const std::stop_token& pause) {
        if (begun == nullptr) begun = begin(plan, PixelFormat::srgb8, job.stage, stop_);
        if (begun == nullptr || !begun->advance(pause)) return false;
        picture = begun->take();
        return true;
    };
    render::byOwner(draw, job.stop);
    return picture;
}

/// The scene of a view in which layer `index` stipples what those before it drew; those after it lie in front
/// of that.
Result<std::optional<render::Scene>> PictureMaker::stippledSceneOf(const View& view, std::size_t index,
                                                                   const RenderJob& job,
                                                                   PictureHistory& history, Making& why) {
    const auto at = static_cast<std::ptrdiff_t>(index);
    const Layer& layer = view.layers[index];
    View before = view;
    before.layers.erase(before.layers.begin() + at, before.layers.end());
    const std::optional<render::Scene> none;
    // Dots that are on their way take one step, not two, where they are also seen themselves.
    DotHistory shown = layer.opacity < 1.0 ? history.dots : DotHistory();
    MOTE_ASSIGN_OR_RETURN(const auto drawn, sceneOf(before, job, history.dots, history, why));
    if (!drawn) return none;
    const auto dots = stippled(*drawn, layer, job, history, why);
    if (!dots.ok()) return inLayer(index, dots.error());
    if (!*dots) return none;
    shown.layers.resize(index);  // what lies in front of a drawing does not fade in
    auto scene = sceneOf(besideDots(view, index), job, shown, history, why);
    if (scene.ok() && *scene) addDots(**scene, **dots, layer);
    return scene;
}

Result<std::optional<render::Scene>> PictureMaker::sceneOf(const RenderJob& job, PictureHistory& history,
                                                           Making& why) {
    MOTE_RETURN_IF_ERROR(checkTowards(job.task->view, steps_));
    View whole = job.task->view;
    MOTE_RETURN_IF_ERROR(placeLayers(whole, steps_));
    MOTE_ASSIGN_OR_RETURN(bool fitted, fitLayers(whole, steps_));
    if (fitted) {
        MOTE_ASSIGN_OR_RETURN(fitted, boxPlots(whole, job.stage, steps_, history.boxes));
    }
    View view = viewAt(std::move(whole), job.part ? job.part->place : nearestPlace);
    const auto stipples = [](const Layer& layer) {
        return layer.opacity > 0.0 && layer.stipple() && !layer.stipple()->source().empty();
    };
    if (!fitted) {
        // Meanwhile all is asked for that it will be drawn from.
        for (auto& layer : view.layers) layer.opacity = stipples(layer) ? 0.0 : layer.opacity;
        DotHistory unseen;
        MOTE_RETURN_IF_ERROR(makeScene(view, job, steps_, photographs_, unseen, [] { return false; }));
        why.waits = true;
        return std::optional<render::Scene>();
    }
    const auto found = std::find_if(view.layers.begin(), view.layers.end(), stipples);
    if (found == view.layers.end()) return sceneOf(view, job, history.dots, history, why);
    const auto index = static_cast<std::size_t>(found - view.layers.begin());
    if (std::any_of(found + 1, view.layers.end(), stipples)) {
        return inLayer(index, {ErrorCode::unsupported, "stipple.source",
                               "only one layer of a view can stipple what the others drew"});
    }
    return stippledSceneOf(view, index, job, history, why);
}

/// Says what the pictures need; whether some of it is on its way.
bool PictureMaker::want(const FramePlan& plan) {
    bool coming = false;
    for (const auto& points : plan.points)
        coming = steps_.want(points.source ? *points.source : *points.step, points.need) || coming;
    return coming;
}

/// Nothing where the picture waits for data.
std::optional<FramePlan> PictureMaker::planFor(const RenderJob& job, const render::Scene& scene,
                                               const Quality& quality) {
    const auto plan = [&](render::Reading reading) {
        return render::makeFramePlan(scene, quality, selections_, device_->abilities(), reading, job.stop);
    };
    auto now = plan(render::Reading::notForPoints);
    if (job.stage != Stage::exact || !now.waits()) return now;
    check(scene);
    if (want(now)) return std::nullopt;
    return plan(render::Reading::all);
}

/// Null where `why` says that the picture waits, or it was stopped.
Result<std::unique_ptr<Draft>> PictureMaker::newDraft(const RenderJob& job, PictureHistory& history,
                                                      Making& why) {
    const auto begun = workClock();
    MOTE_ASSIGN_OR_RETURN(auto scene, sceneOf(job, history, why));
    if (!scene) return std::unique_ptr<Draft>();
    auto draft = planned(job, *std::move(scene), begun, history);
    why.waits = draft == nullptr;
    return draft;
}

/// Null where the picture waits for data.
std::unique_ptr<Draft> PictureMaker::planned(const RenderJob& job, render::Scene scene,
                                             Clock::time_point begun, PictureHistory& history) {
    auto quality = qualityOf(job.stage, loadOf(scene, history), history.quality);
    if (job.part) quality.resolutionScale = job.part->resolutionScale.value_or(quality.resolutionScale);
    const auto planning = workClock();
    auto plan = planFor(job, scene, quality);
    if (!plan) return nullptr;
    auto draft = std::make_unique<Draft>(Draft{.task = job.task,
                                               .stage = job.stage,
                                               .device = device_,
                                               .scene = std::move(scene),
                                               .quality = quality,
                                               .plan = *std::move(plan)});
    // On a page they stay shapes, but where they would have to dissolve.
    if (job.task->page && !job.part) {
        draft->shapes = takeShapes(draft->plan, *job.task->page);
        if (draft->shapes.dots || !draft->shapes.strokes.empty())
            draft->sight = std::make_unique<PageSight>(draft->plan, draft->shapes);
    }
    draft->planMs = milliseconds(workClock() - begun);
    draft->learnMs = milliseconds(workClock() - planning);
    return draft;
}

/// Whether all is found that a page's shapes ask for.
bool PictureMaker::findSight(const RenderJob& job, Draft& draft, const std::stop_token& pause) {
    if (draft.sight == nullptr) return true;
    const auto begun = Clock::now();
    const bool found = draft.sight->advance(*device_, pause, job.stop);
    draft.planMs += milliseconds(Clock::now() - begun);
    if (!found) return false;
    draft.sights = draft.sight->take();
    draft.sight.reset();
    return true;
}

/// Whether the picture is done.
bool PictureMaker::draw(const RenderJob& job, Draft& draft, const std::stop_token& pause) {
    if (!findSight(job, draft, pause)) {
        check(draft.scene);
        want(draft.plan);
        return false;
    }
    const auto begun = Clock::now();
    const auto asked = job.stage == Stage::exact ? job.task->format : PixelFormat::srgb8;
    const auto format = job.part ? PixelFormat::linearHalf : asked;
    if (draft.picture == nullptr) draft.picture = begin(draft.plan, format, job.stage, job.stop);
    const bool done = draft.picture != nullptr && draft.picture->advance(pause);
    check(draft.scene);
    // Not before: what is read for this picture goes first.
    want(draft.plan);
    draft.renderMs += milliseconds(Clock::now() - begun);
    return done;
}

MadePicture PictureMaker::finished(const RenderJob& job, Draft& draft, PictureHistory& history) {
    const auto& plan = draft.plan;
    const double share = shareOf(plan, draft.quality);
    auto picture = draft.picture->take();
    // What surfaces take is taken by their plan.
    if (anything(draft.scene.view))
        learn(history, draft.scene, picture, draft.quality, share, draft.learnMs + draft.renderMs);
    MadePicture made{std::move(picture),
                     {},
                     stageAfter(job.stage, draft.scene, history),
                     draft.shapes.dots,
                     std::move(draft.shapes.strokes),
                     std::move(draft.sights),
                     annotationsOf(draft.scene, plan, steps_),
                     plan.points.empty() && plan.fields.empty() && !plan.anyDots(),
                     draft.quality.resolutionScale,
                     std::move(draft.memory)};
    made.memory.shrink(encodingBytes(made.picture, made.annotations != nullptr, job.task->page.has_value()));
    describe(made, job, name_);
    if (draft.scene.view.cameraFitted) *made.message.mutable_camera() = toProto(draft.scene.view.camera);
    made.message.set_point_fraction(share);
    for (const auto& shown : {draft.shapes.dots, plan.dots})
        if (shown) made.message.set_points_drawn(made.message.points_drawn() + shown->size());
    made.message.set_queued_ms(
        std::max(0.0, milliseconds(Clock::now() - job.task->arrived) - draft.planMs - draft.renderMs));
    made.message.set_plan_ms(draft.planMs);
    made.message.set_render_ms(draft.renderMs);
    return made;
}

}  // namespace mote::server
