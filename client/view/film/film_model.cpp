// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/film/film_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "client/view/apply_edits.h"
#include "protocol/base/mote_check.h"
#include "protocol/scene/view.h"

namespace mote::client {
namespace {

constexpr double farthest = 1e9;  // seconds, either way, as checkScript() has it

std::string_view wordOf(Easing easing) {
    switch (easing) {
        case Easing::smooth:
            return "smooth";
        case Easing::hold:
            return "hold";
        default:
            return "";
    }
}

bool mayBe(FilmSize size) {
    return size.width >= 1 && size.height >= 1 && size.width <= View::maxSide &&
           size.height <= View::maxSide && std::uint64_t{size.width} * size.height <= View::maxPixels;
}

proto::View ofSize(proto::View view, FilmSize size) {
    view.set_width(size.width);
    view.set_height(size.height);
    return view;
}

Error noRoom(std::string message) {
    return {ErrorCode::resourceExhausted, "", std::move(message)};
}

/// Videos have even sides.
std::uint32_t even(std::uint32_t side) {
    return std::max(side & ~1U, 2U);
}

}  // namespace

Result<FilmModel> FilmModel::fromScript(const proto::Script& script) {
    MOTE_RETURN_IF_ERROR(checkScript(script));
    if (script.keyframes().empty()) {
        return Error{ErrorCode::unsupported, script.views().empty() ? "moves" : "views",
                     "films of keyframes are edited here, and this script has none"};
    }
    FilmModel model;
    if (script.has_fps()) model.fps_ = script.fps();
    model.constantSpeed_ = script.constant_speed();
    if (script.between_steps() == "blend") model.betweenSteps_ = BetweenSteps::blend;
    const auto& first = script.keyframes(0).view();
    model.size_ = {first.width(), first.height()};
    for (const auto& keyframe : script.keyframes()) {
        model.keyframes_.push_back({keyframe.seconds(), keyframe.view(),
                                    parseEasing(keyframe.easing()).value_or(Easing::linear),
                                    ++model.pictures_});
    }
    model.setFps(model.fps_);
    model.select(0);
    model.read_ = script;
    model.before_ = model.toScript();
    return model;
}

proto::Script FilmModel::saved() const {
    auto script = read_;
    applyEdits(before_, toScript(), script);
    // Keyframes that were read nearer to each other than a frame may be so no more.
    return checkScript(script).ok() ? script : toScript();
}

proto::Script FilmModel::toScript() const {
    proto::Script script;
    script.set_fps(fps_);
    script.set_constant_speed(constantSpeed_);
    if (betweenSteps_ == BetweenSteps::blend) script.set_between_steps("blend");
    for (const auto& keyframe : keyframes_) {
        auto& written = *script.add_keyframes();
        written.set_seconds(keyframe.seconds);
        *written.mutable_view() = keyframe.view;
        if (!constantSpeed_) written.set_easing(std::string(wordOf(keyframe.easing)));
    }
    return script;
}

std::uint64_t FilmModel::frameCount() const {
    return isFilm() ? static_cast<std::uint64_t>(std::llround((end() - begin()) * fps_)) + 1 : 0;
}

double FilmModel::latest() const {
    return std::min(begin() + static_cast<double>(maxFrames - 1) / fps_, farthest);
}

/// Films begin at 0, unless they were written otherwise.
double FilmModel::earliest() const {
    return std::max(std::min(0.0, begin()), end() - static_cast<double>(maxFrames - 1) / fps_);
}

double FilmModel::whole(double seconds, double low, double high) const {
    return std::max(low, std::min(std::round(seconds * fps_) / fps_, high));
}

/// The keyframe before the playhead, where that has a frame's room on both sides.
std::optional<std::size_t> FilmModel::wayOfPlayhead() const {
    for (std::size_t i = 0; i + 1 < keyframes_.size(); ++i) {
        const bool room =
            playhead_ >= keyframes_[i].seconds + frame() && playhead_ <= keyframes_[i + 1].seconds - frame();
        if (room) return i;
    }
    return std::nullopt;
}

Status FilmModel::insert(std::size_t index, FilmKeyframe keyframe) {
    if (keyframes_.size() >= static_cast<std::size_t>(maxKeyframes))
        return noRoom("the film has as many keyframes as it may have");
    keyframes_.insert(keyframes_.begin() + static_cast<std::ptrdiff_t>(index), std::move(keyframe));
    select(index);
    changed();
    return success();
}

Status FilmModel::add(const proto::View& view) {
    MOTE_RETURN_IF_ERROR(parseView(view));
    if (empty()) size_ = {even(view.width()), even(view.height())};
    FilmKeyframe keyframe{0.0, ofSize(view, size_), Easing::linear, pictures_ + 1};
    MOTE_RETURN_IF_ERROR(parseView(keyframe.view));
    std::size_t index = keyframes_.size();
    if (const auto way = wayOfPlayhead()) {
        keyframe.seconds =
            whole(playhead_, keyframes_[*way].seconds + frame(), keyframes_[*way + 1].seconds - frame());
        index = *way + 1;
    } else if (!empty()) {
        if (end() + frame() > latest()) return noRoom("the film is as long as it may be");
        keyframe.seconds = std::min(end() + std::max(usualGap, frame()), latest());
    }
    MOTE_RETURN_IF_ERROR(insert(index, std::move(keyframe)));
    ++pictures_;
    return success();
}

Status FilmModel::duplicate() {
    if (!selected_) return Error{ErrorCode::notFound, "", "no keyframe is selected"};
    FilmKeyframe copy = keyframes_[*selected_];
    if (*selected_ + 1 < keyframes_.size()) {
        const double next = keyframes_[*selected_ + 1].seconds;
        if (next - copy.seconds < 2.0 * frame())
            return noRoom("the next keyframe is too near for one between");
        copy.seconds = (copy.seconds + next) / 2.0;
    } else {
        if (end() + frame() > latest()) return noRoom("the film is as long as it may be");
        copy.seconds = std::min(end() + std::max(usualGap, frame()), latest());
    }
    return insert(*selected_ + 1, std::move(copy));
}

Status FilmModel::replace(const proto::View& view) {
    if (!selected_) return Error{ErrorCode::notFound, "", "no keyframe is selected"};
    auto sized = ofSize(view, size_);
    MOTE_RETURN_IF_ERROR(parseView(sized));
    keyframes_[*selected_].view = std::move(sized);
    keyframes_[*selected_].picture = ++pictures_;
    changed();
    return success();
}

void FilmModel::removeSelected() {
    if (!selected_) return;
    keyframes_.erase(keyframes_.begin() + static_cast<std::ptrdiff_t>(*selected_));
    if (empty()) selected_.reset();
    if (selected_) selected_ = std::min(*selected_, keyframes_.size() - 1);
    setPlayhead(playhead_);
    changed();
}

void FilmModel::move(std::size_t keyframe, double seconds) {
    MOTE_CHECK(keyframe < keyframes_.size());
    if (!std::isfinite(seconds)) return;
    const bool first = keyframe == 0, last = keyframe + 1 == keyframes_.size();
    const double low = first ? earliest() : keyframes_[keyframe - 1].seconds + frame();
    const double high = last ? (first ? farthest : latest()) : keyframes_[keyframe + 1].seconds - frame();
    const double before = std::exchange(keyframes_[keyframe].seconds, whole(seconds, low, high));
    if (keyframes_[keyframe].seconds == before) return;
    // The playhead stays at a keyframe that it was at.
    setPlayhead(playhead_ == before ? keyframes_[keyframe].seconds : playhead_);
    changed();
}

void FilmModel::setEasing(Easing easing) {
    if (!selected_ || keyframes_[*selected_].easing == easing) return;
    keyframes_[*selected_].easing = easing;
    changed();
}

void FilmModel::select(std::size_t keyframe) {
    MOTE_CHECK(keyframe < keyframes_.size());
    selected_ = keyframe;
    playhead_ = keyframes_[keyframe].seconds;
}

void FilmModel::setPlayhead(double seconds) {
    if (std::isfinite(seconds)) playhead_ = std::clamp(seconds, begin(), end());
}

void FilmModel::setFps(double fps) {
    if (!std::isfinite(fps)) return;
    const double ways = empty() ? 0.0 : static_cast<double>(keyframes_.size() - 1);
    const double most =
        isFilm() ? std::min(mostFps, static_cast<double>(maxFrames - 1) / (end() - begin())) : mostFps;
    // As many ways of a frame each must fit in before the end of time.
    const double least = std::max(leastFps, ways / (farthest - begin()));
    fps_ = std::max(least, std::min(fps, most));
    spread();
    setPlayhead(playhead_);
    changed();
}

/// Moves keyframes apart that are nearer than a frame: later ones back, but not beyond the latest time. What
/// is a frame apart but for rounding stays where it is.
void FilmModel::spread() {
    const double rounding = 1e-9 * frame();
    for (std::size_t i = 1; i < keyframes_.size(); ++i) {
        const double least = keyframes_[i - 1].seconds + frame();
        if (keyframes_[i].seconds < least - rounding) keyframes_[i].seconds = least;
    }
    double most = latest();
    for (std::size_t i = keyframes_.size(); i-- > 1; most = keyframes_[i].seconds - frame()) {
        if (keyframes_[i].seconds <= most + rounding) break;
        keyframes_[i].seconds = most;
    }
}

void FilmModel::setSize(FilmSize size) {
    if (!mayBe(size) || size == size_) return;
    size_ = size;
    for (auto& keyframe : keyframes_) keyframe.view = ofSize(std::move(keyframe.view), size);
    changed();
}

void FilmModel::setConstantSpeed(bool constant) {
    constantSpeed_ = constant;
    changed();
}

void FilmModel::setBetweenSteps(BetweenSteps between) {
    betweenSteps_ = between;
    changed();
}

void FilmModel::changed() {
    static std::uint64_t latest = 0;  // of all films
    revision_ = ++latest;
}

}  // namespace mote::client
