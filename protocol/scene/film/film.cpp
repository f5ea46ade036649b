// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/film/film.h"

#include <fmt/format.h>

#include "protocol/base/mote_check.h"
#include "protocol/scene/film/keyframe_timeline.h"
#include "protocol/scene/film/move_timeline.h"

namespace mote {

Result<Film> Film::create(const proto::Script& script, const FilmDatasets& datasets) {
    MOTE_RETURN_IF_ERROR(checkScript(script));
    for (int i = 0; i < script.views_size(); ++i)
        MOTE_RETURN_IF_ERROR(checkDatasets(script.views(i), datasets), fmt::format("views[{}]", i));
    Film film;
    if (script.views_size() > 0) {
        film.views_ = std::make_shared<const proto::Script>(script);
    } else {
        auto timeline = script.keyframes_size() > 0 ? KeyframeTimeline::create(script, datasets)
                                                    : MoveTimeline::create(script, datasets);
        MOTE_RETURN_IF_ERROR(timeline);
        film.timeline_ = *std::move(timeline);
    }
    film.setTimes(script);
    return film;
}

void Film::setTimes(const proto::Script& script) {
    count_ = frameCountOf(script);
    if (script.has_fps()) fps_ = script.fps();
    const auto first = views_ ? views_->views(0) : timeline_->at(timeline_->begin());
    width_ = first.width();
    height_ = first.height();
    const auto frames = static_cast<double>(count_);
    if (!timeline_) {
        spacing_ = 1.0 / fps_;
        seconds_ = frames / fps_;
        return;
    }
    begin_ = timeline_->begin();
    seconds_ = timeline_->end() - begin_;
    // Both ends of keyframes are shown; of moves the end is where the next frame would begin again.
    const double ways = script.keyframes_size() > 0 ? frames - 1.0 : frames;
    spacing_ = ways > 0.0 ? seconds_ / ways : 0.0;
}

proto::View Film::frame(std::size_t index) const {
    MOTE_CHECK(index < count_);
    return views_ ? views_->views(static_cast<int>(index)) : timeline_->at(secondsOf(index));
}

proto::View Film::at(double seconds) const {
    MOTE_CHECK(continuous());
    return timeline_->at(seconds);
}

}  // namespace mote
