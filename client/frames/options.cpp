// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "client/frames/video/video_settings.h"
#include "protocol/cli/command.h"
#include "protocol/scene/page.h"
#include "protocol/scene/view.h"

namespace mote::client {
namespace {

constexpr const char* footer =
    R"(Pictures are DIR/frame-000000.EXT and so on. Each is complete when it appears, as is a video.

Examples:
  mote-frames views.json --connect ~/.mote/connection.json --out pictures
  mote-frames views.json --spawn data=/scratch/plots --device egl --out pictures --format exr
  mote-frames turn.json --spawn data=/scratch/plots --video turn.mp4 --samples 4
  mote-frames turn.json --connect c.json --out frames --video turn.mp4 --keep-frames --resume
  mote-frames turn.json --connect c.json --detach --video mp4      # prints the film's job id
  mote-frames --follow 0123456789abcdef --connect c.json          # until it is made
  mote-frames --fetch 0123456789abcdef --connect c.json --video turn.mp4
  mote-frames --list-jobs --connect c.json
  mote-frames dots.json --connect c.json --out prints --format pdf --page 210x297 --margin 15 --dot 0.3)";

constexpr int mostJobTime = 30 * 86400;  // s, as the server's

/// Each is a run of its own; without one of them a script is drawn.
constexpr std::array<std::pair<const char*, FramesTask>, 7> tasks{{{"--detach", FramesTask::detach},
                                                                   {"--fetch", FramesTask::fetch},
                                                                   {"--job", FramesTask::job},
                                                                   {"--list-jobs", FramesTask::listJobs},
                                                                   {"--follow", FramesTask::follow},
                                                                   {"--cancel", FramesTask::cancel},
                                                                   {"--retry", FramesTask::retry}}};

/// What the command line says before it is checked.
struct RawOptions {
    FramesOptions options;
    std::vector<std::string> connect;
    std::string script, device, format = "png", video, chroma, out, job;
    std::string page, size;
    double margin = 0.0, dot = 0.0;  // mm
    double fps = 30.0;
    int crf = 0, samples = 1, subframes = 8, threads = 0, jobs = 1, patience = 3600;
    bool plotter = false, detach = false, listJobs = false;
};

void declareServers(const cli::Command& app, RawOptions& raw) {
    const auto server = app.group("server", "Which server draws (exactly one of these)");
    server
        .option("--connect", raw.connect,
                "Connection file of a running server; repeatable: they share the frames")
        .repeatable();
    server.option("--spawn", raw.options.roots, "Start a private server with this root, NAME=DIR; repeatable")
        .repeatable();
    server.requireOneOption();
    app.option("--device", raw.device, "Device of the private servers: auto, egl or cpu");
    app.option("--threads", raw.threads, "Threads of all private servers together; default: all cores")
        .range(0, 4096);
    app.option("--jobs", raw.jobs, "Private servers that share the frames").range(1, 64).showDefault();
    app.option("--patience", raw.patience,
               "Seconds without a byte of a picture before a server is given up; 0: never")
        .range(0, 1'000'000)
        .showDefault();
}

void declareSheet(const cli::Command& app, RawOptions& raw) {
    const auto sheet = app.group("sheet", "For svg, eps and pdf");
    sheet
        .option("--page", raw.page,
                "Size in mm; default: as wide as the view's printWidth, or 96 pixels an inch")
        .valueName("WIDTHxHEIGHT");
    sheet.option("--margin", raw.margin, "On each side, mm").valueName("MM");
    sheet.option("--dot", raw.dot, "Diameter of the largest dots, mm; default: as in the picture")
        .valueName("MM");
    sheet.flag("--plotter", raw.plotter, "Draws each dot as a tiny stroke, in the order of a short tour");
}

void declareFilm(const cli::Command& app, RawOptions& raw) {
    const auto film = app.group("film", "For films");
    film.option("--video", raw.video, "Also writes all frames as one video: FILE.mp4, .webm or .gif");
    film.option("--crf", raw.crf, "Quality of the video, lower is better; mp4 0 to 51, webm 0 to 63")
        .range(0, 63);
    film.option("--chroma", raw.chroma,
                "For mp4 and webm: full keeps the colours of single points; halved plays everywhere; "
                "default: full, of a film that a server makes halved")
        .oneOf({"full", "halved"});
    film.option("--fps", raw.fps, "Frames per second, instead of the script's");
    film.flag("--keep-frames", raw.options.keepFrames, "Keeps the pictures beside the video, in --out");
    film.flag("--force", raw.options.force, "Replaces an existing video");
    film.option("--samples", raw.samples, "Samples per pixel: 1, 4, 9 or 16").showDefault();
    film.option("--shutter", raw.options.exposure.shutterDegrees,
                "Motion blur: how long a frame is exposed, 360 being until the next; for keyframes and moves")
        .valueName("DEGREES");
    film.option("--subframes", raw.subframes, "Pictures averaged for one exposure").showDefault();
    film.option("--job", raw.job, "Be a film's job").hidden();
    film.option("--progress-fd", raw.options.progressDescriptor, "Progress as JSON lines").hidden();
}

/// One of these at most is given with an id.
void declareJobs(const cli::Command& app, RawOptions& raw) {
    const auto jobs = app.group("jobs", "Jobs of a running server");
    auto& id = raw.options.jobId;
    jobs.flag("--detach", raw.detach,
              "Hands the film to the server as a job and prints its id; --video says which kind");
    jobs.flag("--again", raw.options.again,
              "With --detach: makes it even if the server has, or is making, the same film");
    jobs.option("--job-time", raw.options.jobTime,
                "With --detach: ends it after so long; never later than the server would")
        .range(1, mostJobTime)
        .valueName("SECONDS");
    jobs.option("--fetch", id, "Fetches what the film job with this id made").valueName("ID");
    jobs.flag("--list-jobs", raw.listJobs, "Prints a line for each job, the latest first");
    jobs.option("--follow", id, "Waits for this job to end, and succeeds if it does").valueName("ID");
    jobs.option("--cancel", id, "Ends this job; a finished film is deleted").valueName("ID");
    jobs.option("--retry", id,
                "Starts a failed or cancelled job, a film or an export anew and prints the new id")
        .valueName("ID");
}

void declare(const cli::Command& app, RawOptions& raw) {
    app.footer(footer);
    app.option("SCRIPT", raw.script, "Script of views, keyframes or moves (JSON), or a saved view");
    declareServers(app, raw);
    app.option("--out", raw.out, "Folder for the pictures; created if absent");
    app.option(
           "--format", raw.format,
           "png (8 bits, sRGB), png16, exr (half floats, linear), jpg (quality 95), or dots and strokes as "
           "shapes: svg, eps or pdf")
        .showDefault();
    app.option("--size", raw.size,
               "Size of every picture in pixels, with the same look; default: as the views say")
        .valueName("WIDTHxHEIGHT");
    app.flag("--annotate", raw.options.annotate,
             "Adds axes, labels, colour and scale bars to views that have no annotations");
    declareSheet(app, raw);
    declareFilm(app, raw);
    declareJobs(app, raw);
    app.flag("--resume", raw.options.resume, "Keeps frames that are complete and show the same");
    app.flag("--json", raw.options.json,
             "Prints a line of JSON for each frame, listed job, or change of a followed job");
    app.flag("--quiet", raw.options.quiet, "No progress on stderr");
}

Status checkFormat(const RawOptions& raw, PictureFormat& format) {
    const auto known = pictureFormat(raw.format);
    if (!known) {
        return invalid("--format",
                       fmt::format("\"{}\" is not a format; there are png, png16, exr, jpg, svg, eps and pdf",
                                   raw.format));
    }
    format = *known;
    return success();
}

struct TwoNumbers {
    double width, height;
};

/// "WIDTHxHEIGHT".
std::optional<TwoNumbers> parseTwo(const std::string& text) {
    const auto cross = text.find('x');
    if (cross == std::string::npos) return std::nullopt;
    const auto width = cli::parseNumber(text.substr(0, cross));
    const auto height = cli::parseNumber(text.substr(cross + 1));
    if (!width || !height) return std::nullopt;
    return TwoNumbers{*width, *height};
}

Status checkSize(RawOptions& raw) {
    if (raw.size.empty()) return success();
    if (raw.script.empty()) return invalid("--size", "is of a script's views");
    const auto size = parseTwo(raw.size);
    const auto whole = [](double side) {
        return side >= 1.0 && side <= View::maxSide && side == std::floor(side);
    };
    if (!size || !whole(size->width) || !whole(size->height))
        return invalid("--size", fmt::format("\"{}\" is not WIDTHxHEIGHT, each 1 to {} pixels", raw.size,
                                             View::maxSide));
    raw.options.size =
        PictureSize{static_cast<std::uint32_t>(size->width), static_cast<std::uint32_t>(size->height)};
    return success();
}

Status checkPage(RawOptions& raw, const cli::Command& app) {
    auto& page = raw.options.page;
    page.set_format(pageFormat(raw.options.format));
    const bool asked = app.count("--page") + app.count("--margin") + app.count("--dot") > 0 || raw.plotter;
    if (page.format() == proto::Page::FORMAT_UNSPECIFIED) {
        if (asked) return invalid("--format", "--page, --margin, --dot and --plotter need svg, eps or pdf");
        return success();
    }
    if (!raw.page.empty()) {
        const auto size = parseTwo(raw.page);
        if (!size) return invalid("--page", fmt::format("\"{}\" is not WIDTHxHEIGHT in mm", raw.page));
        page.set_width(size->width);
        page.set_height(size->height);
    }
    page.set_margin(raw.margin);
    page.set_dot(raw.dot);
    page.set_plotter(raw.plotter);
    const auto checked = parsePage(page);
    if (!checked.ok()) return invalid("--" + checked.error().where, checked.error().message);
    return success();
}

Status checkServers(RawOptions& raw) {
    for (const auto& root : raw.options.roots) {
        const auto equals = root.find('=');
        if (equals == 0 || equals == std::string::npos || equals + 1 == root.size()) {
            return invalid("--spawn", fmt::format("\"{}\" is not NAME=DIR", root));
        }
    }
    const bool spawns = !raw.options.roots.empty();
    if (!raw.device.empty() && !spawns)
        return invalid("--device", "chooses the device of a private server and needs --spawn");
    if (raw.threads > 0 && !spawns) return invalid("--threads", "is of a private server and needs --spawn");
    if (raw.jobs > 1 && !spawns)
        return invalid("--jobs",
                       "starts private servers and needs --spawn; give --connect as often as there are "
                       "running ones");
    if (raw.options.task != FramesTask::draw && raw.connect.size() != 1)
        return invalid("--connect", "one running server is needed");
    return success();
}

Status checkTask(RawOptions& raw, const cli::Command& app) {
    auto& options = raw.options;
    std::string chosen;
    for (const auto& [option, task] : tasks) {
        if (app.count(option) == 0) continue;
        if (!chosen.empty()) return invalid(option, fmt::format("{} and {} are two runs", chosen, option));
        chosen = option;
        options.task = task;
    }
    for (const auto* option : {"--again", "--job-time"}) {
        if (app.count(option) > 0 && !raw.detach) return invalid(option, "is for a film that is detached");
    }
    const bool needsScript = options.task == FramesTask::draw || options.task == FramesTask::detach;
    if (needsScript && raw.script.empty()) return invalid("SCRIPT", "is needed");
    if (!needsScript && !raw.script.empty()) return invalid("SCRIPT", "the job has its own");
    return success();
}

/// Where pictures go.
Status checkOut(const RawOptions& raw) {
    switch (raw.options.task) {
        case FramesTask::job:
        case FramesTask::detach:
            return success();
        case FramesTask::draw:
        case FramesTask::fetch:
            if (!raw.out.empty() || !raw.video.empty()) return success();
            return invalid("--out", "is required: the folder for the pictures; or --video FILE");
        default:
            if (raw.out.empty() && raw.video.empty()) return success();
            return invalid(raw.out.empty() ? "--video" : "--out", "no picture is made");
    }
}

/// A detached film's is only of a kind: "mp4", or a name that ends so.
Status checkVideo(RawOptions& raw, const cli::Command& app) {
    auto& options = raw.options;
    const bool document = options.page.format() != proto::Page::FORMAT_UNSPECIFIED;
    if (!raw.video.empty() && document)
        return invalid("--video", "is made of pixels: not of svg, eps or pdf");
    if (options.task == FramesTask::detach && document)
        return invalid("--format", "a detached film has pictures of pixels: png, png16, exr or jpg");
    if (app.count("--crf") > 0 && raw.video.empty()) return invalid("--crf", "is of a video: give --video");
    if (options.keepFrames && raw.video.empty())
        return invalid("--keep-frames", "is for --video; without it the pictures are all that is made");
    if (options.keepFrames && raw.out.empty()) return invalid("--keep-frames", "needs --out, their folder");
    MOTE_RETURN_IF_ERROR(checkOut(raw));
    const bool named = options.task == FramesTask::draw || options.task == FramesTask::fetch;
    if (named && !raw.video.empty()) MOTE_RETURN_IF_ERROR(videoFormatOf(raw.video));
    if (options.task == FramesTask::fetch && !raw.out.empty() && !raw.video.empty())
        return invalid("--fetch", "either --out or --video");
    return success();
}

Status checkNumbers(RawOptions& raw, const cli::Command& app) {
    auto& exposure = raw.options.exposure;
    exposure.samples = static_cast<unsigned>(std::max(0, raw.samples));
    exposure.subframes = static_cast<unsigned>(std::max(0, raw.subframes));
    const auto checked = checkExposure(exposure);
    if (!checked.ok()) return invalid("--" + checked.error().where, checked.error().message);
    const bool document = raw.options.page.format() != proto::Page::FORMAT_UNSPECIFIED;
    if (document && (exposure.samples > 1 || exposure.blurs()))
        return invalid("--samples", "svg, eps and pdf have shapes, which are not averaged");
    if (app.count("--fps") == 0) return success();
    if (!(raw.fps >= leastFps && raw.fps <= mostFps))
        return invalid("--fps", fmt::format("is a number from {} to {}", leastFps, mostFps));
    raw.options.fps = raw.fps;
    return success();
}

Status check(RawOptions& raw, const cli::Command& app) {
    MOTE_RETURN_IF_ERROR(checkFormat(raw, raw.options.format));
    MOTE_RETURN_IF_ERROR(checkPage(raw, app));
    MOTE_RETURN_IF_ERROR(checkTask(raw, app));
    MOTE_RETURN_IF_ERROR(checkSize(raw));
    MOTE_RETURN_IF_ERROR(checkServers(raw));
    MOTE_RETURN_IF_ERROR(checkVideo(raw, app));
    return checkNumbers(raw, app);
}

FramesOptions toOptions(RawOptions raw, const cli::Command& app) {
    auto& options = raw.options;
    options.script = raw.job.empty() ? raw.script : raw.job;
    options.connect.assign(raw.connect.begin(), raw.connect.end());
    if (!raw.device.empty()) options.device = raw.device;
    options.threads = static_cast<unsigned>(raw.threads);
    options.jobs = static_cast<unsigned>(raw.jobs);
    options.patience = std::chrono::seconds(raw.patience);
    options.out = raw.out;
    options.video = raw.video;
    if (!raw.chroma.empty()) options.chroma = raw.chroma == "full" ? VideoChroma::full : VideoChroma::halved;
    if (app.count("--crf") > 0) options.crf = static_cast<unsigned>(raw.crf);
    return std::move(options);
}

}  // namespace

std::variant<FramesOptions, int> parseFramesOptions(int argc, const char* const* argv) {
    RawOptions raw;
    const cli::Program program("mote-frames renders the views of a script, or a film, to files.",
                               "mote-frames");
    const auto app = program.command();
    declare(app, raw);
    if (const auto end = program.parse(argc, argv, [&] { return check(raw, app); })) return *end;
    return toOptions(std::move(raw), app);
}

}  // namespace mote::client
