// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/film_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "client/frames/frame_key.h"
#include "protocol/scene/json.h"

namespace mote::client {
namespace {

/// Views that a server is asked for ahead: one is drawn, one encoded, one on its way and one waits.
constexpr std::size_t mostAhead = 4;
/// Frames that wait to be written or encoded; with more nothing is asked for.
constexpr std::size_t mostUnfinished = 6;
constexpr unsigned finishingThreads = 2;
/// Frames of one picture, as in a hold, that are made of one drawing.
constexpr std::size_t mostAlike = 8;
/// Each frame is tried so often.
constexpr unsigned mostAttempts = 2;
/// After so many that failed one after the other, the rest is not tried.
constexpr unsigned mostFailuresInRow = 3;

/// Whether a picture keeps strokes of the one before it.
bool remembersStrokes(const Film& film) {
    const auto keeps = [](const proto::View& view) {
        return std::any_of(view.layers().begin(), view.layers().end(),
                           [](const auto& layer) { return layer.ink().coherent(); });
    };
    constexpr std::size_t looks = 1000;
    const std::size_t stride = film.continuous() ? std::max<std::size_t>(1, film.frameCount() / looks) : 1;
    for (std::size_t i = 0; i < film.frameCount(); i += stride) {
        if (keeps(film.frame(i))) return true;
    }
    return false;
}

Error forgotten() {
    return {
        ErrorCode::internal, "",
        "the server was started anew and has forgotten the strokes that the next frame would keep: run the "
        "film again with --resume, which draws it again from its first frame on"};
}

/// Told as the script has it, or by the frame's number.
Error inFrame(const Error& error, const Film& film, std::size_t index) {
    return error.within(fmt::format("{}[{}]", film.continuous() ? "frames" : "views", index));
}

}  // namespace

FilmRun::FilmRun(const FilmOrder& order, std::vector<PictureServer*> servers, std::string dataKey,
                 FrameSink& sink, Wakeup& wakeup, const Interrupt& interrupt)
    : order_(order),
      dataKey_(std::move(dataKey)),
      sink_(sink),
      wakeup_(wakeup),
      interrupt_(interrupt),
      remembers_(remembersStrokes(order.film)),
      finishing_(sink, finishingThreads, [&wakeup] { wakeup(); }),
      reports_(order.json) {
    if (remembers_) servers.resize(1);
    for (auto* const server : servers) places_.push_back({server, {}, server->returns()});
}

/// Everything that decides a frame's bytes.
std::string FilmRun::keyOf(const std::vector<proto::View>& views) const {
    std::string text = fmt::format("2\n{}\n{}\n{}\n", name(order_.format), dataKey_, order_.exposure.side());
    if (order_.page) text += toJsonLine(*order_.page) + "\n";
    for (const auto& view : views) text += toJsonLine(view) + "\n";
    return client::keyOf(text);
}

Status FilmRun::run(ProgressBar& bar) {
    const std::size_t total = order_.film.frameCount();
    while (true) {
        if (interrupt_.requested()) return Error{ErrorCode::cancelled, "", "interrupted"};
        MOTE_RETURN_IF_ERROR(askMore());
        for (auto& place : places_) MOTE_RETURN_IF_ERROR(collect(place));
        MOTE_RETURN_IF_ERROR(settle());
        MOTE_RETURN_IF_ERROR(dropLost());
        bar.show(done_, total);
        if (!drawing()) break;
        wakeup_.wait(signalPatience);
    }
    MOTE_RETURN_IF_ERROR(outcome());
    return sink_.finish([&](std::size_t through) {
        bar.show(through, total, "encoding");
        return !interrupt_.requested();
    });
}

/// Whether anything is still to come.
bool FilmRun::drawing() const {
    const bool asked =
        std::any_of(places_.begin(), places_.end(), [](const Place& place) { return !place.views.empty(); });
    const bool stopped = failuresInRow_ >= mostFailuresInRow;
    return asked || finishing_.open() > 0 ||
           (!stopped && (!again_.empty() || next_ < order_.film.frameCount()));
}

std::optional<std::size_t> FilmRun::nextFrame() {
    if (failuresInRow_ >= mostFailuresInRow) return std::nullopt;
    if (!again_.empty()) {
        const auto index = again_.front();
        again_.pop_front();
        return index;
    }
    if (next_ == order_.film.frameCount()) return std::nullopt;
    return next_++;
}

Status FilmRun::askMore() {
    for (auto& place : places_) {
        if (place.returns != place.server->returns() && remembers_) return forgotten();
    }
    // Turn by turn, so that frames come in about their order.
    for (bool asked = true; asked;) {
        asked = false;
        for (auto& place : places_) {
            if (place.views.size() >= mostAhead || finishing_.open() + sink_.backlog() >= mostUnfinished)
                continue;
            const auto index = nextFrame();
            if (!index) return success();
            MOTE_RETURN_IF_ERROR(ask(place, *index));
            asked = true;
            if (interrupt_.requested()) return success();
        }
    }
    return success();
}

/// Nothing is asked for where the frame stands already.
Status FilmRun::ask(Place& place, std::size_t index) {
    const auto views = viewsOf(order_.film, index, order_.exposure);
    if (!views.ok()) return inFrame(views.error(), order_.film, index);
    const auto& first = views->front();
    const unsigned side = order_.exposure.side();
    const auto open = std::make_shared<Open>();
    open->index = index;
    open->key = keyOf(*views);
    open->left = views->size();
    open->exposure = Exposure(side);
    open->report = {index, sink_.fileOf(index).string(), first.width() / side, first.height() / side, {}, 0};
    if (order_.resume && sink_.has(index, open->key, open->report.width, open->report.height)) {
        sink_.there(index);
        ++done_;
        if (!remembers_) return success();
        open->keep = false;
    }
    if (open->keep) reports_.expect(index);
    if (isLikeLast(open->key)) {
        last_.lock()->alike.push_back(index);
        return success();
    }
    last_ = open;
    for (const auto& view : *views)
        place.views[place.server->ask(view, pixelFormat(order_.format), order_.page)] = open;
    return success();
}

Status FilmRun::collect(Place& place) {
    for (auto& answer : place.server->poll()) {
        const auto found = place.views.find(answer.view);
        if (found == place.views.end()) continue;
        const auto open = found->second;
        place.views.erase(found);
        if (!answer.frame.ok()) {
            // The frame's other views are of no use.
            std::erase_if(place.views, [&](const auto& entry) { return entry.second == open; });
            again_.insert(again_.end(), open->alike.begin(), open->alike.end());
            MOTE_RETURN_IF_ERROR(failed(open->index, answer.frame.error()));
            continue;
        }
        MOTE_RETURN_IF_ERROR(received(*open, *std::move(answer.frame)));
    }
    return success();
}

Status FilmRun::received(Open& open, ReceivedFrame frame) {
    failuresInRow_ = 0;
    open.report.add(frame.message);
    const bool lossless = frame.message.encoding() == proto::Frame::ZSTD;
    open.exposure.add(std::move(frame.pixels));
    open.payload = std::move(frame.payload);
    if (--open.left > 0 || !open.keep) return success();
    const bool asItCame = lossless && order_.exposure.side() == 1 && order_.exposure.views() == 1;
    if (!asItCame) open.payload.clear();
    const auto pixels = open.exposure.take();
    for (const auto index : open.alike) {
        auto& report = drawn_[index] = open.report;
        report.index = index;
        report.file = sink_.fileOf(index).string();
        finishing_.post({index, open.key, pixels, open.payload});
    }
    drawn_[open.index] = open.report;
    finishing_.post({open.index, open.key, pixels, std::move(open.payload)});
    return success();
}

/// Whether a frame shows what the one before it shows, which is not there yet.
bool FilmRun::isLikeLast(const std::string& key) const {
    const auto last = last_.lock();
    return last && !remembers_ && last->key == key && last->alike.size() < mostAlike;
}

/// The frames that it was to be.
void FilmRun::askAgain(const Open& open) {
    again_.push_back(open.index);
    again_.insert(again_.end(), open.alike.begin(), open.alike.end());
}

Status FilmRun::failed(std::size_t index, const Error& error) {
    if (++attempts_[index] < mostAttempts && !remembers_) {
        again_.push_back(index);
        return success();
    }
    ++failuresInRow_;
    errors_.emplace(index, inFrame(error, order_.film, index));
    return reports_.passOver(index);
}

/// What the finishing threads are through with.
Status FilmRun::settle() {
    MOTE_ASSIGN_OR_RETURN(const auto finished, finishing_.take());
    for (const auto index : finished) {
        ++done_;
        attempts_.erase(index);
        const auto report = drawn_.extract(index);
        MOTE_RETURN_IF_ERROR(reports_.say(report.mapped()));
    }
    return success();
}

/// A server that is lost leaves its frames to the others.
Status FilmRun::dropLost() {
    for (std::size_t i = places_.size(); i-- > 0;) {
        const auto reason = places_[i].server->lost();
        if (!reason) continue;
        if (places_.size() == 1) return *reason;
        drop(places_[i]);
        places_.erase(places_.begin() + static_cast<std::ptrdiff_t>(i));
    }
    return success();
}

void FilmRun::drop(Place& place) {
    for (const auto& [view, open] : place.views) {
        if (std::find(again_.begin(), again_.end(), open->index) == again_.end()) askAgain(*open);
    }
    place.views.clear();
    std::sort(again_.begin(), again_.end());
}

Status FilmRun::outcome() const {
    if (errors_.empty()) return success();
    const auto& first = errors_.begin()->second;
    const auto missing = order_.film.frameCount() - done_;
    if (missing <= 1) return first;
    return Error{first.code, first.where, fmt::format("{} ({} frames are missing)", first.message, missing)};
}

}  // namespace mote::client
