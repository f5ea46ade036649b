// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/film/check_script.h"

#include <fmt/format.h>

#include <cmath>
#include <set>

#include "protocol/base/check.h"
#include "protocol/scene/film/easing.h"
#include "protocol/scene/view.h"

namespace mote {
namespace {

constexpr double longest = 1e9;  // seconds: all frames there may be, at the lowest rate

std::string at(std::string_view list, int index) {
    return fmt::format("{}[{}]", list, index);
}

Status checkCount(double frames, std::string_view field) {
    if (frames <= static_cast<double>(maxFrames)) return success();
    return Error{ErrorCode::resourceExhausted, std::string(field),
                 fmt::format("a film has at most {} frames, not {:.0f}", maxFrames, frames)};
}

Status checkNotEmpty(std::uint64_t frames, std::string_view field) {
    if (frames > 0) return success();
    return invalid(std::string(field), "at this rate the film has 0 frames");
}

Status checkViews(const proto::Script& script) {
    MOTE_RETURN_IF_ERROR(checkCount(script.views_size(), "views"));
    for (int i = 0; i < script.views_size(); ++i)
        MOTE_RETURN_IF_ERROR(parseView(script.views(i)), at("views", i));
    return success();
}

Status checkSameSize(const proto::View& first, const proto::View& view) {
    if (view.width() == first.width() && view.height() == first.height()) return success();
    return invalid(view.width() != first.width() ? "view.width" : "view.height",
                   fmt::format("all keyframes have one size, {} x {} as the first, not {} x {}",
                               first.width(), first.height(), view.width(), view.height()));
}

Status checkSameSpace(const proto::View& first, const proto::View& view) {
    if (view.space() == first.space()) return success();
    return invalid("view.space",
                   first.space().empty()
                       ? "all keyframes lie in one space, and the first does not say \"metres\""
                       : fmt::format("all keyframes lie in one space, \"{}\" as the first", first.space()));
}

/// An easing, and whether the film has room for it.
Status checkEasing(const std::string& word, bool constantSpeed) {
    const auto easing = parseEasing(word);
    if (!easing) return invalid("easing", "there are \"linear\", \"smooth\" and \"hold\"");
    if (!constantSpeed || easing == Easing::linear) return success();
    return invalid("easing", "a film of constantSpeed has no easing but \"linear\"");
}

Status checkKeyframe(const proto::Script& script, int index) {
    const auto& keyframe = script.keyframes(index);
    MOTE_RETURN_IF_ERROR(checkRange(keyframe.seconds(), -longest, longest, "seconds"));
    if (index > 0 && !(keyframe.seconds() > script.keyframes(index - 1).seconds())) {
        return invalid("seconds", fmt::format("{} does not lie after {}, the time of the keyframe before",
                                              keyframe.seconds(), script.keyframes(index - 1).seconds()));
    }
    MOTE_RETURN_IF_ERROR(checkEasing(keyframe.easing(), script.constant_speed()));
    if (!keyframe.has_view()) return invalid("view", "a keyframe needs a view");
    MOTE_RETURN_IF_ERROR(parseView(keyframe.view()), "view");
    MOTE_RETURN_IF_ERROR(checkSameSpace(script.keyframes(0).view(), keyframe.view()));
    return checkSameSize(script.keyframes(0).view(), keyframe.view());
}

Status checkKeyframes(const proto::Script& script) {
    const int count = script.keyframes_size();
    if (count < 2) return invalid("keyframes", "a film needs at least two keyframes");
    if (count > maxKeyframes) {
        return Error{ErrorCode::resourceExhausted, "keyframes",
                     fmt::format("a film has at most {} keyframes, not {}", maxKeyframes, count)};
    }
    for (int i = 0; i < count; ++i) MOTE_RETURN_IF_ERROR(checkKeyframe(script, i), at("keyframes", i));
    const double length = script.keyframes(count - 1).seconds() - script.keyframes(0).seconds();
    const double fps = script.has_fps() ? script.fps() : defaultFps;
    return checkCount(std::round(length * fps) + 1.0, fmt::format("keyframes[{}].seconds", count - 1));
}

Status checkTurn(const proto::Move::Turn& turn) {
    MOTE_RETURN_IF_ERROR(checkRange(turn.degrees(), -1e6, 1e6, "degrees"));
    if (turn.axis().empty()) return success();
    MOTE_ASSIGN_OR_RETURN(const auto axis, checkVector(turn.axis(), 1e6, "axis"));
    if (std::hypot(axis.x, axis.y, axis.z) > 1e-6) return success();
    return invalid("axis", "an axis must not be zero");
}

Status checkZoom(const proto::Move::ZoomTo& zoom) {
    if (!zoom.target().empty()) MOTE_RETURN_IF_ERROR(checkVector(zoom.target(), 1e12, "target"));
    if (zoom.factor() != 0.0) MOTE_RETURN_IF_ERROR(checkRange(zoom.factor(), 1e-9, 1e9, "factor"));
    return success();
}

Status checkMove(const proto::Move& move) {
    MOTE_RETURN_IF_ERROR(checkRange(move.seconds(), 0.0, longest, "seconds"));
    if (!(move.seconds() > 0.0)) return invalid("seconds", "a move takes longer than 0 seconds");
    const auto easing = parseEasing(move.easing());
    if (!easing || easing == Easing::hold) return invalid("easing", "there are \"linear\" and \"smooth\"");
    const bool moves = move.has_turn() || move.has_play_steps() || move.has_zoom_to();
    if (!moves && !move.has_hold())
        return invalid("", "a move needs one of \"turn\", \"playSteps\", \"zoomTo\" and \"hold\"");
    if (moves && move.has_hold()) return invalid("hold", "what holds does nothing else at once");
    if (move.has_turn()) MOTE_RETURN_IF_ERROR(checkTurn(move.turn()), "turn");
    if (move.has_zoom_to()) MOTE_RETURN_IF_ERROR(checkZoom(move.zoom_to()), "zoomTo");
    return success();
}

Status checkMoves(const proto::Script& script) {
    if (!script.has_view()) return invalid("view", "moves need a view where they begin");
    if (script.moves_size() == 0) return invalid("moves", "a film of a view needs at least one move");
    if (script.moves_size() > maxKeyframes) {
        return Error{ErrorCode::resourceExhausted, "moves",
                     fmt::format("a film has at most {} moves, not {}", maxKeyframes, script.moves_size())};
    }
    MOTE_RETURN_IF_ERROR(parseView(script.view()), "view");
    double length = 0.0;
    for (int i = 0; i < script.moves_size(); ++i) {
        MOTE_RETURN_IF_ERROR(checkMove(script.moves(i)), at("moves", i));
        length += script.moves(i).seconds();
    }
    const double fps = script.has_fps() ? script.fps() : defaultFps;
    MOTE_RETURN_IF_ERROR(checkCount(std::round(length * fps), "moves"));
    return checkNotEmpty(frameCountOf(script), "moves");
}

/// That a script is made of one thing, and that what it says beside it belongs to that.
Status checkParts(const proto::Script& script) {
    const bool views = script.views_size() > 0, keyframes = script.keyframes_size() > 0;
    const bool moves = script.has_view() || script.moves_size() > 0;
    if (!views && !keyframes && !moves)
        return invalid("views", "a script needs at least one view, or keyframes, or a view and its moves");
    if (views + keyframes + moves > 1) {
        return invalid(
            keyframes ? "keyframes" : "moves",
            "a script is made of views, or of keyframes, or of a view and its moves, not of several of them");
    }
    if (script.constant_speed() && !keyframes)
        return invalid("constantSpeed", "is of the camera's way through keyframes, and there are none");
    const auto& between = script.between_steps();
    if (between.empty() || between == "hold" || between == "blend") return success();
    return invalid("betweenSteps", "there are \"hold\" and \"blend\"");
}

}  // namespace

Status checkScript(const proto::Script& script) {
    MOTE_RETURN_IF_ERROR(checkParts(script));
    if (script.has_fps()) MOTE_RETURN_IF_ERROR(checkRange(script.fps(), leastFps, mostFps, "fps"));
    if (script.views_size() > 0) return checkViews(script);
    return script.keyframes_size() > 0 ? checkKeyframes(script) : checkMoves(script);
}

std::uint64_t frameCountOf(const proto::Script& script) {
    const double fps = script.has_fps() ? script.fps() : defaultFps;
    if (script.views_size() > 0) return static_cast<std::uint64_t>(script.views_size());
    if (script.keyframes_size() > 0) {
        const auto &first = *script.keyframes().begin(), &last = *script.keyframes().rbegin();
        return static_cast<std::uint64_t>(std::llround((last.seconds() - first.seconds()) * fps)) + 1;
    }
    double length = 0.0;
    for (const auto& move : script.moves()) length += move.seconds();
    return static_cast<std::uint64_t>(std::llround(length * fps));
}

std::vector<std::string> datasetsOf(const proto::Script& script) {
    std::set<std::string> names;
    const auto add = [&](const proto::View& view) {
        for (const auto& layer : view.layers()) {
            names.insert(layer.dataset());
            if (!layer.stipple().image().empty()) names.insert(layer.stipple().image());
        }
    };
    for (const auto& view : script.views()) add(view);
    for (const auto& keyframe : script.keyframes()) add(keyframe.view());
    add(script.view());
    return {names.begin(), names.end()};
}

}  // namespace mote
