// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/remote_film.h"

#include <fmt/format.h>

#include <string>
#include <system_error>
#include <utility>

#include "client/frames/picture_file.h"
#include "client/frames/print_line.h"
#include "client/frames/progress_bar.h"
#include "client/frames/running_server.h"
#include "client/frames/video_of_frames.h"
#include "client/shared/film_download.h"
#include "client/shared/jobs.h"
#include "client/shared/server_jobs.h"
#include "protocol/scene/film/check_script.h"
#include "protocol/scene/film_job.h"
#include "protocol/scene/utf8.h"

namespace mote::client {
namespace {

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

/// Of a detached film: "mp4", or a file's name that ends so; empty: it has none.
Result<std::string> videoKind(const fs::path& video) {
    if (video.empty()) return std::string();
    const auto extension = video.extension().string();
    auto kind = extension.empty() ? video.string() : extension.substr(1);
    if (videoFormat(kind)) return kind;
    return Error{ErrorCode::invalidArgument, "--video",
                 fmt::format("there are mp4, webm and gif, not \"{}\"", kind)};
}

}  // namespace

Status detachFilm(const FramesOptions& options, const proto::Script& script, const Interrupt& interrupt) {
    MOTE_ASSIGN_OR_RETURN(const auto kind, videoKind(options.video));
    auto request = filmRequest(script, kind);
    auto& film = *request.mutable_film();
    if (options.format != PictureFormat::png) film.set_format(std::string(name(options.format)));
    if (options.crf) film.set_quality(*options.crf);
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

}  // namespace mote::client
