// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <memory>
#include <string>
#include <system_error>
#include <utility>

#include "client/frames/draw_film.h"
#include "client/frames/frame_report.h"
#include "client/frames/options.h"
#include "client/frames/picture_file.h"
#include "client/frames/video_file.h"
#include "client/shared/film_download.h"
#include "client/shared/interrupt.h"
#include "client/shared/jobs.h"
#include "client/shared/script.h"
#include "client/shared/server_line.h"
#include "protocol/base/complain.h"
#include "protocol/base/error.h"
#include "protocol/base/json.h"
#include "protocol/base/utf8.h"
#include "protocol/scene/film/check_script.h"
#include "protocol/scene/film/film_job.h"
#include "protocol/scene/film/sized_script.h"

namespace mote::client {
namespace {

/// The first running server of the options, which has welcomed us. Errors: as ServerLine::waitUntilConnected.
Result<std::unique_ptr<ServerLine>> runningServer(const FramesOptions& options, Wakeup& wakeup,
                                                  const Interrupt& interrupt) {
    MOTE_ASSIGN_OR_RETURN(auto server,
                          ServerLine::open("mote-frames", {options.connect.front()}, wakeup, interrupt));
    MOTE_RETURN_IF_ERROR(server->waitUntilConnected());
    return server;
}

namespace fs = std::filesystem;

/// What the line brings of one film.
class Fetching {
  public:
    explicit Fetching(ServerLine& server) : server_(server) {}

    /// The video, or the pictures, as files; how many they are.
    Result<std::uint64_t> save(const proto::JobStatus& job, const fs::path& target, ProgressBar& bar) {
        MOTE_ASSIGN_OR_RETURN(const auto download, FilmDownload::begin(job, target));
        while (!download->done()) {
            const auto piece = server_.answerTo<FilmBytes>(
                [&](auto reply) { server_.line().fetchFilm(download->wanted(), std::move(reply)); });
            MOTE_RETURN_IF_ERROR(download->take(piece));
            bar.show(download->filesDone(), download->filesDone() + 1, "fetching");
        }
        return download->filesDone();
    }

  private:
    ServerLine& server_;
};

/// The pictures of a job, into a folder; how many they are.
Result<std::uint64_t> fetchPictures(Fetching& fetching, const proto::JobStatus& job, const fs::path& folder,
                                    ProgressBar& bar) {
    const auto& film = job.request().film();
    if (!film.video().empty()) {
        return Error{
            ErrorCode::unsupported, "--out",
            fmt::format("this film was made as {} alone: give --video FILE.{}", film.video(), film.video())};
    }
    return fetching.save(job, folder, bar);
}

/// Makes the video of pictures that were fetched.
Status videoOfFolder(const FramesOptions& options, const proto::FilmJob& film, const fs::path& folder,
                     std::uint64_t count, const Interrupt& interrupt) {
    const auto read = [&](std::size_t index) -> Result<FramePixels> {
        if (interrupt.requested()) return Error{ErrorCode::cancelled, "", "interrupted"};
        return readPictureFrame(folder / filmPictureName(film, static_cast<std::uint32_t>(index)));
    };
    MOTE_ASSIGN_OR_RETURN(const auto first, read(0));
    VideoSettings settings;
    settings.format = *videoFormat(options.video.extension().string());
    settings.width = first.width;
    settings.height = first.height;
    settings.fps = options.fps.value_or(film.script().has_fps() ? film.script().fps() : defaultFps);
    settings.quality = options.crf;
    settings.chroma = options.chroma.value_or(VideoChroma::full);
    MOTE_RETURN_IF_ERROR(checkVideo(settings));
    return videoOfFrames(options.video, settings, count, read);
}

Status fetchVideo(Fetching& fetching, const proto::JobStatus& job, const FramesOptions& options,
                  ProgressBar& bar, const Interrupt& interrupt) {
    const auto& film = job.request().film();
    MOTE_ASSIGN_OR_RETURN(const auto format, videoFormatOf(options.video));
    if (!film.video().empty()) {
        if (videoFormat(film.video()) != format)
            return Error{
                ErrorCode::unsupported, "--video",
                fmt::format("this film was made as {}: give --video FILE.{}", film.video(), film.video())};
        MOTE_RETURN_IF_ERROR(fetching.save(job, options.video, bar));
        return success();
    }
    const auto folder =
        options.video.parent_path() / fmt::format(".{}.fetched", options.video.filename().string());
    auto made = [&]() -> Status {
        MOTE_ASSIGN_OR_RETURN(const auto count, fetchPictures(fetching, job, folder, bar));
        return videoOfFolder(options, film, folder, count, interrupt);
    }();
    std::error_code ignored;
    fs::remove_all(folder, ignored);
    return made;
}

/// The container of a detached film: "mp4", or a file's name that ends so; empty: it has none.
Result<std::string> videoKind(const fs::path& video) {
    if (video.empty()) return std::string();
    const auto extension = video.extension().string();
    auto kind = extension.empty() ? video.string() : extension.substr(1);
    if (videoFormat(kind)) return kind;
    return Error{ErrorCode::invalidArgument, "--video",
                 fmt::format("there are mp4, webm and gif, not \"{}\"", kind)};
}

/// Submits the script as a job and prints its id. Errors: the server's, among them what is wrong with the
/// script.
Status detachFilm(const FramesOptions& options, const proto::Script& script, const Interrupt& interrupt) {
    MOTE_ASSIGN_OR_RETURN(const auto kind, videoKind(options.video));
    auto request = filmRequest(script, kind);
    auto& film = *request.mutable_film();
    if (options.format != PictureFormat::png) film.set_format(std::string(name(options.format)));
    if (options.crf) film.set_quality(*options.crf);
    if (options.chroma) film.set_chroma(options.chroma == VideoChroma::full ? "full" : "halved");
    film.set_samples(options.exposure.samples);
    film.set_shutter_degrees(options.exposure.shutterDegrees);
    if (options.exposure.blurs()) film.set_subframes(options.exposure.subframes);
    Wakeup wakeup;
    MOTE_ASSIGN_OR_RETURN(const auto server, runningServer(options, wakeup, interrupt));
    MOTE_ASSIGN_OR_RETURN(const auto job, server->answerTo<proto::JobStatus>([&](auto reply) {
        server->line().submitJob(request, std::move(reply), {options.again, options.jobTime});
    }));
    return print(toTerminalText(job.id()) + "\n");
}

/// Brings what a job made: its video, a video of its pictures, or its pictures. Errors: the server's (there
/// is no such job, it is no film, it is not done), unsupported (it made nothing of that kind), the disk's.
Status fetchFilm(const FramesOptions& options, const Interrupt& interrupt) {
    std::error_code code;
    if (!options.video.empty() && !options.force && fs::exists(options.video, code))
        return Error{ErrorCode::alreadyExists, options.video.string(),
                     "is there already; --force replaces it"};
    Wakeup wakeup;
    MOTE_ASSIGN_OR_RETURN(const auto server, runningServer(options, wakeup, interrupt));
    MOTE_ASSIGN_OR_RETURN(const auto job, findJob(*server, options.jobId));
    if (!job.request().has_film()) {
        return Error{ErrorCode::invalidArgument, "--fetch", fmt::format("job {} is no film", options.jobId)};
    }
    Fetching fetching(*server);
    ProgressBar bar(!options.quiet, -1);
    if (options.video.empty()) {
        MOTE_RETURN_IF_ERROR(fetchPictures(fetching, job, options.out, bar));
        return success();
    }
    return fetchVideo(fetching, job, options, bar, interrupt);
}

std::string jsonOf(const proto::JobStatus& job) {
    return toJsonLine(job, true) + "\n";
}

/// What is to be said of it beside its state.
const std::string& remark(const proto::JobStatus& job) {
    if (!isUnderWay(job)) return job.error();
    return job.waits_for().empty() ? job.phase() : job.waits_for();
}

std::string lineOf(const proto::JobStatus& job) {
    const auto line =
        fmt::format("{}  {:<9}  {:3.0f}%  {}{}{}", job.id(), stateName(job.state()), 100.0 * job.progress(),
                    jobName(job.request()), remark(job).empty() ? "" : ": ", remark(job));
    return toTerminalText(line) + "\n";
}

Status listJobs(ServerLine& server, bool json) {
    Status printed = success();
    MOTE_RETURN_IF_ERROR(eachJob(server, [&](const proto::JobStatus& job) {
        printed = print(json ? jsonOf(job) : lineOf(job));
        return printed.ok();
    }));
    return printed;
}

/// How it ended.
Result<proto::JobStatus> watchJob(ServerLine& server, const FramesOptions& options) {
    JobPercentage percentage("job", !options.quiet);
    return awaitJob(server, options.jobId, [&](const proto::JobStatus& job) -> Status {
        percentage.show(job);
        return options.json ? print(jsonOf(job)) : success();
    });
}

/// A job that failed shows the last lines of its log, unless they are in what was printed of it, or nobody
/// wants to read them.
Status followJob(ServerLine& server, const FramesOptions& options) {
    MOTE_ASSIGN_OR_RETURN(const auto job, watchJob(server, options));
    if (job.state() == proto::JobStatus::SUCCEEDED) return success();
    if (!options.json && !options.quiet) {
        for (const auto& line : job.log()) complain("mote-frames", line);
    }
    return Error{ErrorCode::internal, options.jobId,
                 job.error().empty() ? fmt::format("the job was {}", stateName(job.state())) : job.error()};
}

Status cancelJob(ServerLine& server, const std::string& id) {
    MOTE_RETURN_IF_ERROR(server.answerTo<proto::JobStatus>(
        [&](auto reply) { server.line().cancelJob(id, std::move(reply)); }));
    return success();
}

Status retryJob(ServerLine& server, const std::string& id) {
    MOTE_ASSIGN_OR_RETURN(const auto job, server.answerTo<proto::JobStatus>([&](auto reply) {
        server.line().retryJob(id, std::move(reply));
    }));
    return print(toTerminalText(job.id()) + "\n");
}

/// Does what a task of listJobs, follow, cancel or retry says. Errors: the server's (there is no such job, it
/// cannot be tried again), of follow why the job failed, internal (stdout), cancelled (interrupted).
Status runJobCommand(const FramesOptions& options, const Interrupt& interrupt) {
    Wakeup wakeup;
    MOTE_ASSIGN_OR_RETURN(const auto server, runningServer(options, wakeup, interrupt));
    if (options.task == FramesTask::listJobs) return listJobs(*server, options.json);
    if (options.task == FramesTask::follow) return followJob(*server, options);
    if (options.task == FramesTask::cancel) return cancelJob(*server, options.jobId);
    return retryJob(*server, options.jobId);
}

Status runScript(const FramesOptions& options, const Interrupt& interrupt) {
    const auto size = options.size.value_or(PictureSize{});
    MOTE_ASSIGN_OR_RETURN(auto script, readScript(options.script, size.width, size.height));
    if (options.annotate) script = annotatedScript(std::move(script));
    script = withStillAxes(std::move(script));
    if (options.size) {
        auto sized = sizedScript(std::move(script), options.size->width, options.size->height);
        MOTE_RETURN_IF_ERROR(sized, options.script.string() + " with --size");
        script = *std::move(sized);
    }
    if (options.fps) {
        script.set_fps(*options.fps);
        MOTE_RETURN_IF_ERROR(checkScript(script), options.script.string());
    }
    if (options.task == FramesTask::detach) return detachFilm(options, script, interrupt);
    return drawFilm(options, script, options.script.string(), interrupt);
}

Status runTask(const FramesOptions& options, const Interrupt& interrupt) {
    switch (options.task) {
        case FramesTask::draw:
        case FramesTask::detach:
            return runScript(options, interrupt);
        case FramesTask::fetch:
            return fetchFilm(options, interrupt);
        case FramesTask::job:
            return drawFilmJob(options, interrupt);
        default:
            return runJobCommand(options, interrupt);
    }
}

}  // namespace
}  // namespace mote::client

int main(int argc, char** argv) {
    using namespace mote::client;
    return runProgram("mote-frames", parseFramesOptions, runTask, argc, argv);
}
