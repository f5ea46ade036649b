// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/remote_film.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <system_error>

#include "client/frames/picture_file.h"
#include "client/frames/progress_bar.h"
#include "client/frames/video_of_frames.h"
#include "client/shared/film_download.h"
#include "client/shared/server_line.h"
#include "protocol/scene/film/check_script.h"
#include "protocol/scene/film_job.h"
#include "protocol/scene/utf8.h"

namespace mote::client {
namespace {

namespace fs = std::filesystem;

/// What the line brings of one film.
class Fetching {
  public:
    Fetching(ServerLine& server, std::string id) : server_(server), id_(std::move(id)) {}

    /// The status of the job. Errors: notFound.
    Result<proto::JobStatus> job() {
        for (std::uint64_t first = 0;;) {
            MOTE_ASSIGN_OR_RETURN(const auto page, server_.answerTo<proto::Jobs>([&](auto reply) {
                server_.line().listJobs(first, std::move(reply));
            }));
            const auto found = std::find_if(page.jobs().begin(), page.jobs().end(),
                                            [&](const auto& job) { return job.id() == id_; });
            if (found != page.jobs().end()) return checked(*found);
            if (page.jobs().empty())
                return Error{ErrorCode::notFound, "--fetch",
                             fmt::format("the server knows no job \"{}\"", id_)};
            first += static_cast<std::uint64_t>(page.jobs_size());
        }
    }

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
    Result<proto::JobStatus> checked(const proto::JobStatus& job) const {
        if (job.request().has_film()) return job;
        return Error{ErrorCode::invalidArgument, "--fetch", fmt::format("job {} is no film", id_)};
    }

    ServerLine& server_;
    const std::string id_;
};

Result<std::unique_ptr<ServerLine>> connected(const FramesOptions& options, Wakeup& wakeup,
                                              const Interrupt& interrupt) {
    MOTE_ASSIGN_OR_RETURN(auto server,
                          ServerLine::open("mote-frames", {options.connect.front()}, wakeup, interrupt));
    MOTE_RETURN_IF_ERROR(server->waitUntilConnected());
    return server;
}

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

/// Of pictures that were fetched.
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
    settings.chroma = options.chroma;
    MOTE_RETURN_IF_ERROR(checkVideo(settings));
    return videoOfFrames(options.video, settings, count, read);
}

Status fetchVideo(Fetching& fetching, const proto::JobStatus& job, const FramesOptions& options,
                  ProgressBar& bar, const Interrupt& interrupt) {
    const auto& film = job.request().film();
    const auto format = videoFormat(options.video.extension().string());
    if (!format) {
        return Error{
            ErrorCode::invalidArgument, "--video",
            fmt::format("\"{}\" is no video: FILE.mp4, FILE.webm or FILE.gif", options.video.string())};
    }
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
    const auto made = [&]() -> Status {
        MOTE_ASSIGN_OR_RETURN(const auto count, fetchPictures(fetching, job, folder, bar));
        return videoOfFolder(options, film, folder, count, interrupt);
    }();
    std::error_code ignored;
    fs::remove_all(folder, ignored);
    return made;
}

}  // namespace

Status detachFilm(const FramesOptions& options, const proto::Script& script, const Interrupt& interrupt) {
    proto::JobRequest request;
    auto& film = *request.mutable_film();
    *film.mutable_script() = script;
    if (options.format != PictureFormat::png) film.set_format(std::string(name(options.format)));
    if (!options.video.empty()) {
        // "mp4", or the name of a file.
        const auto extension = options.video.extension().string();
        const auto kind = extension.empty() ? options.video.string() : extension.substr(1);
        if (!videoFormat(kind))
            return Error{ErrorCode::invalidArgument, "--video",
                         fmt::format("there are mp4, webm and gif, not \"{}\"", kind)};
        film.set_video(kind);
    }
    if (options.crf) film.set_quality(*options.crf);
    film.set_samples(options.exposure.samples);
    film.set_shutter_degrees(options.exposure.shutterDegrees);
    if (options.exposure.blurs()) film.set_subframes(options.exposure.subframes);
    Wakeup wakeup;
    MOTE_ASSIGN_OR_RETURN(const auto server, connected(options, wakeup, interrupt));
    MOTE_ASSIGN_OR_RETURN(const auto job, server->answerTo<proto::JobStatus>([&](auto reply) {
        server->line().submitJob(request, std::move(reply), options.again);
    }));
    fmt::print("{}\n", toTerminalText(job.id()));
    return success();
}

Status fetchFilm(const FramesOptions& options, const Interrupt& interrupt) {
    std::error_code code;
    if (!options.video.empty() && !options.force && fs::exists(options.video, code))
        return Error{ErrorCode::alreadyExists, options.video.string(),
                     "is there already; --force replaces it"};
    Wakeup wakeup;
    MOTE_ASSIGN_OR_RETURN(const auto server, connected(options, wakeup, interrupt));
    Fetching fetching(*server, options.fetch);
    MOTE_ASSIGN_OR_RETURN(const auto job, fetching.job());
    ProgressBar bar(!options.quiet, -1);
    if (options.video.empty()) {
        MOTE_RETURN_IF_ERROR(fetchPictures(fetching, job, options.out, bar));
        return success();
    }
    return fetchVideo(fetching, job, options, bar, interrupt);
}

}  // namespace mote::client
