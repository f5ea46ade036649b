// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/draw_film.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <thread>
#include <vector>

#include "client/frames/film_run.h"
#include "client/frames/frame_key.h"
#include "client/frames/frame_store.h"
#include "client/frames/picture_files.h"
#include "client/frames/video/video_key.h"
#include "client/frames/video_file.h"
#include "client/shared/known_datasets.h"
#include "protocol/scene/complain.h"
#include "protocol/scene/film_job.h"
#include "protocol/scene/json.h"

namespace mote::client {
namespace {

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

Result<Servers> openServers(const FramesOptions& options, Wakeup& wakeup, const Interrupt& interrupt) {
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
    if (options.jobs > 1 || options.threads > 0) command.threads = std::max(1U, cores / options.jobs);
    for (unsigned i = 0; i < options.jobs; ++i) {
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

/// All servers must have the same to draw, and draw it alike.
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

std::optional<VideoSettings> videoOf(const FramesOptions& options, const Film& film) {
    if (options.video.empty()) return std::nullopt;
    VideoSettings settings;
    settings.format = videoFormat(options.video.extension().string()).value_or(VideoFormat::mp4);
    settings.width = film.width();
    settings.height = film.height();
    settings.fps = film.fps();
    settings.quality = options.crf;
    settings.chroma = options.chroma;
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
    if (!videoFormat(video.extension().string())) {
        return Error{ErrorCode::invalidArgument, "--video",
                     fmt::format("\"{}\" is no video: FILE.mp4, FILE.webm or FILE.gif", video.string())};
    }
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

FilmOrder orderOf(const FramesOptions& options, const Film& film) {
    FilmOrder order{film};
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
    MOTE_ASSIGN_OR_RETURN(const auto servers, openServers(options, wakeup, interrupt));
    MOTE_ASSIGN_OR_RETURN(const auto known, askAll(servers, script));
    const auto film = Film::create(script, known.datasets);
    if (!film.ok())
        return Error{film.error().code, fmt::format("{}: {}", name, film.error().where),
                     film.error().message};
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
    const auto order = orderOf(options, *film);
    std::vector<PictureServer*> places;
    for (const auto& server : servers) places.push_back(server.get());
    ProgressBar bar(!options.quiet, options.progressDescriptor);
    const auto drawn = FilmRun(order, places, known.key, *sink, wakeup, interrupt).run(bar);
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
    options.exposure.samples = std::max(1U, job.samples());
    options.exposure.shutterDegrees = job.shutter_degrees();
    if (job.subframes() > 0) options.exposure.subframes = job.subframes();
    MOTE_RETURN_IF_ERROR(checkExposure(options.exposure), "film");
    return drawFilm(options, job.script(), "film.script", interrupt);
}

}  // namespace mote::client
