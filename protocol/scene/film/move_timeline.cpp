// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/film/move_timeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <utility>

#include "protocol/scene/film/legal_camera.h"
#include "protocol/scene/film/rotation.h"
#include "protocol/scene/mix.h"
#include "protocol/scene/view.h"

namespace mote {
namespace {

glm::dvec3 vectorOf(const google::protobuf::RepeatedField<double>& field) {
    return {field[0], field[1], field[2]};
}

/// The axis as long as the angle.
glm::dvec3 turnOf(const proto::Move::Turn& turn, const Camera& camera) {
    const glm::dvec3 axis = turn.axis().empty() ? camera.up : vectorOf(turn.axis());
    return glm::radians(turn.degrees()) * glm::normalize(axis);
}

/// A layer where its steps are: in one, or on its way from one to the next.
void showIn(const std::vector<ShownStep>& steps, proto::Layer& layer) {
    layer.set_step(steps.front().step);
    layer.clear_towards();
    if (steps.size() == 1) return;
    layer.mutable_towards()->set_step(steps.back().step);
    layer.mutable_towards()->set_share(steps.back().weight);
}

}  // namespace

glm::dvec3 MoveTimeline::Move::offsetAt(double share) const {
    const double nearer = camera.perspective() ? std::exp(-share * zoom) : 1.0;
    return nearer * (rotationBy(share * turn) * (camera.eye - camera.target));
}

Camera MoveTimeline::Move::cameraAt(double share) const {
    Camera result = camera;
    result.target = mix(camera.target, target, share);
    result.eye = result.target + offsetAt(share);
    result.up = rotationBy(share * turn) * camera.up;
    if (camera.orthographicHeight)
        result.orthographicHeight = std::exp(-share * zoom) * *camera.orthographicHeight;
    return result;
}

/// A move that begins where the last one ended.
MoveTimeline::Move MoveTimeline::next(const proto::Move& message) const {
    Move move;
    if (!moves_.empty()) move.begin = moves_.back().end;
    move.easing = parseEasing(message.easing()).value_or(Easing::linear);
    move.camera = moves_.empty() ? camera_ : moves_.back().cameraAt(1.0);
    move.end = move.begin + message.seconds();
    move.target = move.camera.target;
    if (message.has_turn()) move.turn = turnOf(message.turn(), move.camera);
    const auto& zoom = message.zoom_to();
    if (!zoom.target().empty()) move.target = vectorOf(zoom.target());
    if (zoom.factor() != 0.0) move.zoom = std::log(zoom.factor());
    for (int i = 0; i < view_.layers_size(); ++i) {
        if (moves_.empty()) {
            move.steps.push_back({view_.layers(i).step(), view_.layers(i).step()});
            continue;
        }
        const auto& before = moves_.back().steps[static_cast<std::size_t>(i)];
        move.steps.push_back({before.to, before.to, false, before.left || before.played});
    }
    return move;
}

Status MoveTimeline::play(const proto::Move::PlaySteps& message, const FilmDatasets& datasets,
                          Move& move) const {
    bool shown = false, played = false;
    for (int i = 0; i < view_.layers_size(); ++i) {
        const auto& name = view_.layers(i).dataset();
        if (!message.dataset().empty() && message.dataset() != name) continue;
        shown = true;
        const auto& dataset = datasets.at(name);
        if (dataset.steps == 0) continue;
        played = true;
        MOTE_RETURN_IF_ERROR(checkStep(name, dataset, message.from(), "from"));
        MOTE_RETURN_IF_ERROR(checkStep(name, dataset, message.to(), "to"));
        move.steps[static_cast<std::size_t>(i)] = {message.from(), message.to(), true};
    }
    if (played) return success();
    if (!shown)
        return Error{ErrorCode::notFound, "dataset",
                     fmt::format("no layer of the view shows \"{}\"", message.dataset())};
    return Error{ErrorCode::invalidArgument, "dataset", "what the view shows has no steps to be played"};
}

Status MoveTimeline::add(const proto::Move& message, const FilmDatasets& datasets) {
    Move move = next(message);
    if (message.has_play_steps())
        MOTE_RETURN_IF_ERROR(play(message.play_steps(), datasets, move), "playSteps");
    const auto arrived = parseCamera(toProto(move.cameraAt(1.0)));
    if (!arrived.ok()) {
        return Error{ErrorCode::invalidArgument, message.has_zoom_to() ? "zoomTo" : "turn",
                     fmt::format("the camera would come where none may be ({}: {})", arrived.error().where,
                                 arrived.error().message)};
    }
    moves_.push_back(std::move(move));
    return success();
}

Result<std::unique_ptr<const Timeline>> MoveTimeline::create(const proto::Script& script,
                                                             const FilmDatasets& datasets) {
    MOTE_RETURN_IF_ERROR(checkDatasets(script.view(), datasets), "view");
    auto view = parseView(script.view());
    MOTE_RETURN_IF_ERROR(view, "view");
    MOTE_RETURN_IF_ERROR(fitToDatasets(*view, datasets), "view");
    const auto between = script.between_steps() == "blend" ? BetweenSteps::blend : BetweenSteps::hold;
    std::unique_ptr<MoveTimeline> timeline(new MoveTimeline(script.view(), between));
    timeline->camera_ = view->camera;
    *timeline->view_.mutable_camera() = toProto(view->camera);
    for (int i = 0; i < script.moves_size(); ++i)
        MOTE_RETURN_IF_ERROR(timeline->add(script.moves(i), datasets), fmt::format("moves[{}]", i));
    return std::unique_ptr<const Timeline>(std::move(timeline));
}

BetweenSteps MoveTimeline::betweenSteps(const proto::Layer& layer) const {
    return layer.has_particles() || layer.has_hybrid() ? between_ : BetweenSteps::hold;
}

std::vector<ShownStep> MoveTimeline::stepsOf(int layer, const Steps& steps, double share) const {
    if (!steps.played) return {{steps.from, 1.0}};
    return stepsPlayed(steps.from, steps.to, share, betweenSteps(view_.layers(layer)));
}

proto::View MoveTimeline::at(double seconds) const {
    const auto next = std::upper_bound(moves_.begin(), moves_.end() - 1, seconds,
                                       [](double time, const auto& move) { return time < move.end; });
    const Move& move = *next;
    const double time = std::clamp((seconds - move.begin) / (move.end - move.begin), 0.0, 1.0);
    const double share = eased(move.easing, time);
    proto::View view = view_;
    Camera camera = move.camera;
    if (move.movesCamera()) {
        camera = move.cameraAt(share);
        camera = placed(camera, camera.target, move.offsetAt(share));
    }
    *view.mutable_camera() = toProto(camera);
    for (int i = 0; i < view_.layers_size(); ++i) {
        const auto& steps = move.steps[static_cast<std::size_t>(i)];
        if (steps.played || steps.left) showIn(stepsOf(i, steps, share), *view.mutable_layers(i));
    }
    return view;
}

}  // namespace mote
