// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/draw_film.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include "client/frames/frame_sink.h"
#include "client/frames/frame_store.h"
#include "client/frames/video/video_settings.h"
#include "client/frames/video_file.h"
#include "client/shared/script.h"
#include "protocol/base/complain.h"
#include "protocol/base/json.h"
#include "protocol/scene/film/film_job.h"
#include "protocol/scene/view.h"

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
      finishing_(sink, finishingThreads, [&wakeup] { wakeup(); }),
      reports_(order.json) {
    if (order.keepsStrokes) servers.resize(1);
    for (auto* const server : servers) places_.push_back({server, {}, server->returns()});
}

/// Everything that decides a frame's bytes.
std::string FilmRun::keyOf(const std::vector<proto::View>& views) const {
    std::string text = fmt::format("3\n{}\n{}\n{}\n", name(order_.format), dataKey_, order_.exposure.side());
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

/// Tells whether anything is still to come.
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
        if (place.returns != place.server->returns() && order_.keepsStrokes) return forgotten();
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

/// Asks for the frame unless it stands already.
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
        if (!order_.keepsStrokes) return success();
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
    auto pixels = open.exposure.take();
    for (const auto index : open.alike) {
        auto& report = drawn_[index] = open.report;
        report.index = index;
        report.file = sink_.fileOf(index).string();
        finishing_.post({index, open.key, pixels, open.payload});
    }
    drawn_[open.index] = open.report;
    finishing_.post({open.index, open.key, std::move(pixels), std::move(open.payload)});
    return success();
}

/// Tells whether a frame shows what the one before it shows, which is not there yet.
bool FilmRun::isLikeLast(const std::string& key) const {
    const auto last = last_.lock();
    return last && !order_.keepsStrokes && last->key == key && last->alike.size() < mostAlike;
}

/// The frames that it was to be.
void FilmRun::askAgain(const Open& open) {
    again_.push_back(open.index);
    again_.insert(again_.end(), open.alike.begin(), open.alike.end());
}

Status FilmRun::failed(std::size_t index, const Error& error) {
    if (++attempts_[index] < mostAttempts && !order_.keepsStrokes) {
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

namespace {

/// Ink of keyframes and moves is coherent where it does not say so: one frame follows from the other. Views
/// of a list are pictures by themselves.
proto::Script withCoherentInk(proto::Script script) {
    const auto say = [](proto::View& view) {
        for (auto& layer : *view.mutable_layers()) {
            if (layer.has_ink() && !layer.ink().has_coherent()) layer.mutable_ink()->set_coherent(true);
        }
    };
    for (auto& keyframe : *script.mutable_keyframes()) say(*keyframe.mutable_view());
    if (script.moves_size() > 0) say(*script.mutable_view());
    return script;
}

bool keepsStrokes(const proto::View& view) {
    return std::any_of(view.layers().begin(), view.layers().end(),
                       [](const auto& layer) { return layer.ink().coherent(); });
}

/// Tells whether a picture of a script keeps strokes of the one before it: one server draws them all.
bool keepsStrokes(const proto::Script& script) {
    const auto any = [](const auto& parts, const auto& viewOf) {
        return std::any_of(parts.begin(), parts.end(),
                           [&](const auto& part) { return keepsStrokes(viewOf(part)); });
    };
    return keepsStrokes(script.view()) ||
           any(script.views(), [](const auto& view) -> const proto::View& { return view; }) ||
           any(script.keyframes(), [](const auto& frame) -> const proto::View& { return frame.view(); });
}

using Servers = std::vector<std::unique_ptr<PictureServer>>;

/// What servers say of the datasets that a script shows.
struct KnownData {
    FilmDatasets datasets;
    std::string key;  ///< of all that decides a picture beside its view
};

/// Threads share the cores; how many they are changes no picture.
std::string withoutThreads(const std::string& device) {
    const auto comma = device.rfind(", ");
    const bool threads =
        device.find(" thread", comma == std::string::npos ? device.size() : comma) != std::string::npos;
    return threads ? device.substr(0, comma) : device;
}

/// `jobs`: how many private ones.
Result<Servers> openServers(const FramesOptions& options, unsigned jobs, Wakeup& wakeup,
                            const Interrupt& interrupt) {
    Servers servers;
    const bool job = options.task == FramesTask::job;
    // In the background it waits as long as others look.
    const auto patience = job ? std::chrono::seconds(0) : options.patience;
    for (const auto& file : options.connect) {
        const ServerChoice choice{file, {}, job, job ? options.script : std::filesystem::path()};
        MOTE_ASSIGN_OR_RETURN(auto server, PictureServer::open(choice, patience, wakeup, interrupt));
        servers.push_back(std::move(server));
    }
    if (!servers.empty()) return servers;
    const unsigned cores =
        options.threads > 0 ? options.threads : std::max(1U, std::thread::hardware_concurrency());
    ServerCommand command{serverBesideUs(), options.roots, options.device, 0};
    if (jobs > 1 || options.threads > 0) command.threads = std::max(1U, cores / jobs);
    for (unsigned i = 0; i < jobs; ++i) {
        MOTE_ASSIGN_OR_RETURN(auto server, PictureServer::open({{}, command}, patience, wakeup, interrupt));
        servers.push_back(std::move(server));
    }
    return servers;
}

Result<KnownData> askServer(PictureServer& server, const proto::Script& script) {
    MOTE_RETURN_IF_ERROR(server.waitUntilConnected());
    MOTE_ASSIGN_OR_RETURN(const auto catalogue, server.answerTo<proto::Catalogue>([&](auto reply) {
        server.line().listDatasets(std::move(reply));
    }));
    const auto welcome = server.line().welcome();
    KnownData known{knownDatasets(catalogue),
                    fmt::format("{}\n{}\n", welcome.server(), withoutThreads(welcome.device()))};
    for (const auto& name : datasetsOf(script)) {
        if (known.datasets.count(name) == 0) continue;  // told with its place in the script
        MOTE_ASSIGN_OR_RETURN(const auto description, server.answerTo<proto::Description>([&](auto reply) {
            server.line().describe(name, std::move(reply));
        }));
        known.datasets[name] = knownDataset(description.manifest());
        known.key += toJsonLine(description.manifest()) + "\n";
    }
    return known;
}

/// Checks that all servers have the same to draw, and draw it alike.
Result<KnownData> askAll(const Servers& servers, const proto::Script& script) {
    std::optional<KnownData> first;
    for (std::size_t i = 0; i < servers.size(); ++i) {
        MOTE_ASSIGN_OR_RETURN(auto known, askServer(*servers[i], script));
        if (first && known.key != first->key) {
            return Error{
                ErrorCode::invalidArgument, "--connect",
                fmt::format("server {} has another device, version or data than the first: their frames "
                            "would not go together",
                            i + 1)};
        }
        if (!first) first = std::move(known);
    }
    return *std::move(first);
}

/// The camera that the server fits to what a view shows; none where it fits none.
Result<std::optional<proto::Camera>> fittedCamera(PictureServer& server, proto::View view, Wakeup& wakeup,
                                                  const Interrupt& interrupt) {
    // Nothing of this picture stays: the film's first one keeps no strokes of it.
    for (auto& layer : *view.mutable_layers()) {
        if (layer.has_ink()) layer.mutable_ink()->clear_coherent();
    }
    const auto asked = server.ask(view, proto::SRGB8, {});
    while (true) {
        if (interrupt.requested()) return Error{ErrorCode::cancelled, "", "interrupted"};
        for (auto& answer : server.poll()) {
            if (answer.view != asked) continue;
            MOTE_RETURN_IF_ERROR(answer.frame);
            const auto& message = answer.frame->message;
            return message.has_camera() ? std::optional(message.camera()) : std::nullopt;
        }
        if (const auto lost = server.lost()) return *lost;
        wakeup.wait(signalPatience);
    }
}

struct StepRange {
    std::uint32_t first = 0, last = 0;
};

/// The steps that moves play of a layer; none where they play none, or some that are not there.
std::optional<StepRange> playedSteps(const proto::Script& script, const proto::Layer& layer,
                                     const FilmDatasets& datasets) {
    std::optional<StepRange> range;
    const auto steps = static_cast<std::uint32_t>(datasets.at(layer.dataset()).steps);
    for (const auto& move : script.moves()) {
        const auto& play = move.play_steps();
        const bool ours = play.dataset().empty() || play.dataset() == layer.dataset();
        if (!move.has_play_steps() || !ours) continue;
        const auto [low, high] = std::minmax({play.from(), play.to()});
        if (high >= steps) return std::nullopt;
        if (!range) range = StepRange{low, high};
        *range = {std::min(range->first, low), std::max(range->last, high)};
    }
    return range;
}

/// What the beginning of a film shows and, beside it, steps that its moves play: as many, evenly among them,
/// as a view has layers for. A camera that is fitted to it sees the film, not its beginning alone.
proto::View withPlayedSteps(const proto::Script& script, const FilmDatasets& datasets) {
    auto view = script.view();
    std::vector<std::pair<int, StepRange>> played;
    for (int i = 0; i < script.view().layers_size(); ++i) {
        if (const auto range = playedSteps(script, script.view().layers(i), datasets))
            played.emplace_back(i, *range);
    }
    if (played.empty()) return view;
    const auto each = (View::maxLayers - view.layers_size()) / static_cast<int>(played.size());
    for (const auto& [index, range] : played) {
        const auto& layer = script.view().layers(index);
        std::set<std::uint32_t> shown{layer.step()};
        // The last step comes first, unless the beginning shows it: it may be the only one that has a place.
        const double from = layer.step() == range.last ? range.first : range.last;
        const double to = layer.step() == range.last ? range.last : range.first;
        for (int k = 0; k < each; ++k) {
            const double step = from + (to - from) * k / std::max(each - 1, 1);
            if (!shown.insert(static_cast<std::uint32_t>(std::lround(step))).second) continue;
            auto& more = *view.add_layers();
            more = layer;
            more.set_step(static_cast<std::uint32_t>(std::lround(step)));
            more.clear_towards();
        }
    }
    return view;
}

/// A film of which a keyframe, or the beginning, leaves the camera out looks from where a picture of that
/// view does, and of all steps that it plays: its server knows what is shown.
Status fitFilm(PictureServer& server, proto::Script& script, const FilmDatasets& datasets, Wakeup& wakeup,
               const Interrupt& interrupt) {
    // What is wrong with a view is told with its place, before anything is drawn.
    const auto wanted = [&](const proto::View& view) {
        return !view.has_camera() && !view.layers().empty() && checkDatasets(view, datasets).ok();
    };
    const auto fit = [&](proto::View& view, const proto::View& shown) -> Status {
        MOTE_ASSIGN_OR_RETURN(const auto camera, fittedCamera(server, shown, wakeup, interrupt));
        if (camera) *view.mutable_camera() = *camera;
        return success();
    };
    for (int i = 0; i < script.keyframes_size(); ++i) {
        auto& view = *script.mutable_keyframes(i)->mutable_view();
        if (wanted(view)) MOTE_RETURN_IF_ERROR(fit(view, view), fmt::format("keyframes[{}].view", i));
    }
    if (script.moves_size() == 0 || !wanted(script.view())) return success();
    auto& view = *script.mutable_view();
    // Where the server cannot hold several steps at once, the beginning decides.
    if (fit(view, withPlayedSteps(script, datasets)).ok()) return success();
    MOTE_RETURN_IF_ERROR(fit(view, view), "view");
    return success();
}

std::optional<VideoSettings> videoOf(const FramesOptions& options, const Film& film) {
    if (options.video.empty()) return std::nullopt;
    VideoSettings settings;
    settings.format = videoFormat(options.video.extension().string()).value_or(VideoFormat::mp4);
    settings.width = film.width();
    settings.height = film.height();
    settings.fps = film.fps();
    settings.quality = options.crf;
    settings.chroma = options.chroma.value_or(VideoChroma::full);
    return settings;
}

/// Of one size: frames of a video are not resized.
Status checkSizes(const Film& film) {
    if (film.continuous()) return success();
    for (std::size_t i = 0; i < film.frameCount(); ++i) {
        const auto view = film.frame(i);
        if (view.width() == film.width() && view.height() == film.height()) continue;
        return Error{ErrorCode::invalidArgument, fmt::format("views[{}].width", i),
                     fmt::format("all frames of a video have one size: {} x {}, not {} x {}", film.width(),
                                 film.height(), view.width(), view.height())};
    }
    return success();
}

Status checkTarget(const FramesOptions& options) {
    const auto& video = options.video;
    MOTE_RETURN_IF_ERROR(videoFormatOf(video));
    std::error_code code;
    if (options.resume || options.force || !std::filesystem::exists(video, code)) return success();
    return Error{ErrorCode::alreadyExists, video.string(), "is there already; --force replaces it"};
}

/// Everything that decides a video's bytes.
std::string videoKey(const FramesOptions& options, const VideoSettings& video, const proto::Script& script,
                     const std::string& dataKey) {
    return keyOf(fmt::format(
        "{}\n{}\n{} {} {} {}\n{} {} {}\n", dataKey, toJsonLine(script), name(video.format), video.fps,
        video.quality.value_or(defaultQuality(video.format)), static_cast<int>(video.chroma),
        options.exposure.samples, options.exposure.shutterDegrees, options.exposure.subframes));
}

Result<std::unique_ptr<FrameSink>> sinkOf(const FramesOptions& options, const Film& film,
                                          const std::string& key) {
    std::unique_ptr<FrameSink> pictures;
    if (!options.out.empty() && (options.video.empty() || options.keepFrames))
        pictures = std::make_unique<PictureFiles>(options.out, options.format);
    const auto video = videoOf(options, film);
    if (!video) return pictures;
    MOTE_RETURN_IF_ERROR(checkTarget(options));
    MOTE_RETURN_IF_ERROR(checkSizes(film));
    const auto checked = checkVideo(*video);
    if (!checked.ok()) return Error{checked.error().code, "--video", checked.error().toString()};
    return std::unique_ptr<FrameSink>(
        std::make_unique<VideoFile>(options.video, *video, film.frameCount(), key, std::move(pictures)));
}

/// `keepsStrokes`: as its script says.
FilmOrder orderOf(const FramesOptions& options, const Film& film, bool keepsStrokes) {
    FilmOrder order{film, keepsStrokes};
    order.format = options.video.empty() || options.keepFrames ? options.format : PictureFormat::png;
    if (options.page.format() != proto::Page::FORMAT_UNSPECIFIED) order.page = options.page;
    order.exposure = options.exposure;
    order.resume = options.resume;
    order.json = options.json;
    return order;
}

/// A run that stopped says how to go on.
void tellKept(const FramesOptions& options, const FrameSink& sink) {
    const auto kept = sink.kept();
    if (!kept.empty() && !options.quiet) complain("mote-frames", kept);
}

}  // namespace

Status drawFilm(const FramesOptions& options, const proto::Script& script, const std::string& name,
                const Interrupt& interrupt) {
    Wakeup wakeup;
    auto fitted = withCoherentInk(script);
    const bool keeps = keepsStrokes(fitted);
    MOTE_ASSIGN_OR_RETURN(const auto servers,
                          openServers(options, keeps ? 1U : options.jobs, wakeup, interrupt));
    MOTE_ASSIGN_OR_RETURN(const auto known, askAll(servers, script));
    const auto inScript = [&](const Error& error) {
        return Error{error.code, fmt::format("{}: {}", name, error.where), error.message};
    };
    const auto fits = fitFilm(*servers.front(), fitted, known.datasets, wakeup, interrupt);
    if (!fits.ok()) return inScript(fits.error());
    const auto film = Film::create(fitted, known.datasets);
    if (!film.ok()) return inScript(film.error());
    const auto video = videoOf(options, *film);
    const auto key = video ? videoKey(options, *video, script, known.key) : std::string();
    if (video && options.resume && !options.keepFrames && readVideoKey(options.video, video->format) == key) {
        // Who was killed between the last two steps left frames that nobody needs.
        if (FrameStore left(options.video); std::filesystem::exists(left.folder()) && left.open(true).ok())
            left.discard();
        return success();
    }
    MOTE_ASSIGN_OR_RETURN(const auto sink, sinkOf(options, *film, key));
    MOTE_RETURN_IF_ERROR(sink->open(options.resume));
    const auto order = orderOf(options, *film, keeps);
    std::vector<PictureServer*> places;
    places.reserve(servers.size());
    for (const auto& server : servers) places.push_back(server.get());
    ProgressBar bar(!options.quiet, options.progressDescriptor);
    auto drawn = FilmRun(order, places, known.key, *sink, wakeup, interrupt).run(bar);
    if (!drawn.ok()) tellKept(options, *sink);
    return drawn;
}

Status drawFilmJob(const FramesOptions& given, const Interrupt& interrupt) {
    proto::JobRequest request;
    MOTE_RETURN_IF_ERROR(readJsonFile(given.script, request));
    const auto& job = request.film();
    MOTE_RETURN_IF_ERROR(checkScript(job.script()), "film.script");
    const auto folder = given.script.parent_path() / "film";
    FramesOptions options = given;
    options.resume = true;
    options.quiet = true;
    options.format = pictureFormat(job.format().empty() ? "png" : job.format()).value_or(PictureFormat::png);
    if (job.video().empty()) options.out = folder;
    if (!job.video().empty()) options.video = folder / filmVideoName(job);
    if (job.has_quality()) options.crf = job.quality();
    options.chroma = job.chroma() == "full" ? VideoChroma::full : VideoChroma::halved;
    options.exposure.samples = std::max(1U, job.samples());
    options.exposure.shutterDegrees = job.shutter_degrees();
    if (job.subframes() > 0) options.exposure.subframes = job.subframes();
    MOTE_RETURN_IF_ERROR(checkExposure(options.exposure), "film");
    return drawFilm(options, job.script(), "film.script", interrupt);
}

}  // namespace mote::client
