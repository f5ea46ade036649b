// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/film/keyframe_timeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "protocol/scene/film/check_script.h"
#include "protocol/scene/mix.h"
#include "protocol/scene/view_message.h"

namespace mote {
namespace {

std::string nameOf(std::size_t keyframe) {
    return fmt::format("keyframes[{}]", keyframe);
}

template <class Keyframes>
std::vector<CameraPath::Stop> stopsOf(const Keyframes& keyframes) {
    std::vector<CameraPath::Stop> stops;
    for (const auto& keyframe : keyframes)
        stops.push_back({keyframe.seconds, keyframe.view.camera, keyframe.easing == Easing::hold});
    return stops;
}

}  // namespace

Result<std::vector<KeyframeTimeline::Keyframe>> KeyframeTimeline::read(const proto::Script& script,
                                                                       const FilmDatasets& datasets) {
    std::vector<Keyframe> keyframes;
    for (const auto& message : script.keyframes()) {
        const auto name = nameOf(keyframes.size());
        MOTE_RETURN_IF_ERROR(checkDatasets(message.view(), datasets), name + ".view");
        auto view = parseView(message.view());
        MOTE_RETURN_IF_ERROR(view, name + ".view");
        MOTE_RETURN_IF_ERROR(fitToDatasets(*view, datasets), name + ".view");
        auto written = message.view();
        if (view->cameraFitted) *written.mutable_camera() = toProto(view->camera);
        view->cameraFitted = false;
        // What is said and what is usual, and what is said at two scales, have something in between as
        // pixels.
        view = lengthsInPixels(*std::move(view));
        keyframes.push_back({message.seconds(), parseEasing(message.easing()).value_or(Easing::linear),
                             *std::move(view), std::move(written)});
    }
    return keyframes;
}

KeyframeTimeline::KeyframeTimeline(const proto::Script& script, std::vector<Keyframe> keyframes)
    : keyframes_(std::move(keyframes)), path_(stopsOf(keyframes_)) {
    const auto between = script.between_steps() == "blend" ? BetweenSteps::blend : BetweenSteps::hold;
    for (std::size_t i = 0; i + 1 < keyframes_.size(); ++i)
        layers_.emplace_back(keyframes_[i].view.layers, keyframes_[i + 1].view.layers, between);
    const double fps = script.has_fps() ? script.fps() : defaultFps;
    rounding_ = 1e-9 / fps + 4e-16 * std::max(std::abs(begin()), std::abs(end()));
}

Status KeyframeTimeline::checkLayers() const {
    for (std::size_t i = 0; i < layers_.size(); ++i) {
        const auto most = layers_[i].mostLayers();
        if (keyframes_[i].easing == Easing::hold || most <= std::size_t{View::maxLayers}) continue;
        return Error{
            ErrorCode::invalidArgument, nameOf(i + 1) + ".view.layers",
            fmt::format("between {} and {} a view would need {} layers at once, as those that come, go or "
                        "dissolve are shown together; it has at most {}",
                        nameOf(i), nameOf(i + 1), most, View::maxLayers)};
    }
    return success();
}

/// Where the camera does not move at all, the film goes by time.
Status KeyframeTimeline::goEvenly() {
    PathLength length(path_);
    if (!(length.total() > 1e-12 * (1.0 + glm::length(keyframes_.front().view.camera.target))))
        return success();
    for (std::size_t i = 0; i < path_.ways(); ++i) {
        if (length.ofWay(i) > 1e-9 * length.total()) continue;
        return Error{ErrorCode::invalidArgument, nameOf(i + 1) + ".view.camera",
                     fmt::format("the camera does not move from {} to here, which takes no time in a film of "
                                 "constantSpeed",
                                 nameOf(i))};
    }
    length_.emplace(std::move(length));
    return success();
}

Result<std::unique_ptr<const Timeline>> KeyframeTimeline::create(const proto::Script& script,
                                                                 const FilmDatasets& datasets) {
    auto keyframes = read(script, datasets);
    MOTE_RETURN_IF_ERROR(keyframes);
    std::unique_ptr<KeyframeTimeline> timeline(new KeyframeTimeline(script, *std::move(keyframes)));
    MOTE_RETURN_IF_ERROR(timeline->checkLayers());
    if (script.constant_speed()) MOTE_RETURN_IF_ERROR(timeline->goEvenly());
    return std::unique_ptr<const Timeline>(std::move(timeline));
}

KeyframeTimeline::Place KeyframeTimeline::placeAt(double seconds) const {
    const auto last = keyframes_.size() - 1;
    if (!(seconds > begin() + rounding_)) return {0, 0.0};
    if (seconds >= end() - rounding_) return {last, 0.0};
    if (length_) {
        const auto place = length_->at(length_->total() * (seconds - begin()) / (end() - begin()));
        constexpr double near = 1e-12;
        if (place.share <= near) return {place.way, 0.0};
        return place.share >= 1.0 - near ? Place{place.way + 1, 0.0} : Place{place.way, place.share};
    }
    const auto next =
        std::upper_bound(keyframes_.begin(), keyframes_.end(), seconds + rounding_,
                         [](double time, const auto& keyframe) { return time < keyframe.seconds; });
    const auto way = static_cast<std::size_t>(next - keyframes_.begin()) - 1;
    if (seconds <= keyframes_[way].seconds + rounding_) return {way, 0.0};
    return {way, (seconds - keyframes_[way].seconds) / (next->seconds - keyframes_[way].seconds)};
}

/// The camera comes to rest where a way begins or ends slowly, on the other side of the keyframe as well: its
/// speed does not jump.
double KeyframeTimeline::cameraShare(std::size_t way, double share) const {
    if (length_) return share;
    const auto rests = [&](std::size_t i, bool alsoHolds) {
        const auto easing = keyframes_[i].easing;
        return easing == Easing::smooth || (alsoHolds && easing == Easing::hold);
    };
    const bool own = rests(way, false);
    const bool atBegin = own || (way > 0 && rests(way - 1, false));
    const bool atEnd = own || (way + 2 < keyframes_.size() && rests(way + 1, true));
    if (!atBegin && !atEnd) return share;
    return easedBetween(share, atBegin ? 0.0 : 1.0, atEnd ? 0.0 : 1.0);
}

proto::View KeyframeTimeline::between(const Place& place) const {
    const auto &from = keyframes_[place.keyframe], &to = keyframes_[place.keyframe + 1];
    const double share = eased(from.easing, place.share);
    View view;
    view.width = from.view.width;
    view.height = from.view.height;
    view.background = mix(from.view.background, to.view.background, share);
    view.camera = path_.at(place.keyframe, cameraShare(place.keyframe, place.share));
    view.layers = layers_[place.keyframe].at(share);
    view.depthContrast = std::lerp(from.view.depthContrast, to.view.depthContrast, share);
    if (from.view.metres && to.view.metres)
        view.metres = Metres{mix(from.view.metres->stretch, to.view.metres->stretch, share)};
    view.annotations = mixAnnotations(from.view.annotations, to.view.annotations, share);
    return toProto(view);
}

proto::View KeyframeTimeline::at(double seconds) const {
    const Place place = placeAt(seconds);
    const auto& keyframe = keyframes_[place.keyframe];
    if (place.share == 0.0 || keyframe.easing == Easing::hold) return keyframe.message;
    return between(place);
}

}  // namespace mote
