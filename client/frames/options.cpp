// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/options.h"

#include <fmt/format.h>

#include <algorithm>

#include "protocol/cli/command.h"
#include "protocol/scene/page.h"

namespace mote::client {
namespace {

/// What the command line says before it is checked.
struct RawOptions {
    FramesOptions options;
    std::string connect, device, format = "png", video;
    double fps = 30.0;
    std::string page;
    double margin = 0.0, dot = 0.0;  // mm
    bool plotter = false;
};

void declare(const cli::Command& app, RawOptions& raw) {
    app.footer(
        "Pictures are DIR/frame-000000.EXT and so on, each complete when it appears.\n\n"
        "Examples:\n"
        "  mote-frames views.json --connect ~/.mote/connection.json --out pictures\n"
        "  mote-frames views.json --spawn data=/scratch/plots --device egl --out pictures --format exr\n"
        "  mote-frames views.json --connect c.json --out pictures --resume --json > frames.jsonl\n"
        "  mote-frames dots.json --connect c.json --out prints --format pdf --page 210x297 --margin 15 --dot "
        "0.3");
    app.option("SCRIPT", raw.options.script, "Script of views (JSON), one picture each").required();
    const auto server = app.group("server", "Which server draws (exactly one of these)");
    server.option("--connect", raw.connect, "Connection file of a running server");
    server.option("--spawn", raw.options.roots, "Start a private server with this root, NAME=DIR; repeatable")
        .repeatable();
    server.requireOneOption();
    app.option("--device", raw.device, "Device of the private server: auto, egl or cpu");
    app.option("--out", raw.options.out, "Folder of the pictures; made if it is not there").required();
    app.option(
           "--format", raw.format,
           "png (8 bits, sRGB), exr (half floats, linear), jpg (quality 95), or dots and strokes as shapes: "
           "svg, eps or pdf")
        .showDefault();
    const auto sheet = app.group("sheet", "Of svg, eps and pdf");
    sheet.option("--page", raw.page, "Size in mm; 96 pixels an inch unless given").valueName("WIDTHxHEIGHT");
    sheet.option("--margin", raw.margin, "On each side, mm").valueName("MM");
    sheet.option("--dot", raw.dot, "Diameter of the largest dots, mm; as in the picture unless given")
        .valueName("MM");
    sheet.flag("--plotter", raw.plotter, "Each dot a tiny stroke, in the order of a short tour");
    app.option("--video", raw.video, "Not in this version");
    app.option("--fps", raw.fps, "Not in this version");
    app.flag("--resume", raw.options.resume, "Keep pictures that are whole and show the same view");
    app.flag("--json", raw.options.json, "One line of JSON a picture on stdout");
    app.flag("--quiet", raw.options.quiet, "No progress on stderr");
}

Error refusal(const std::string& option, const std::string& why) {
    return {ErrorCode::invalidArgument, option, why};
}

Status checkFormat(const RawOptions& raw, PictureFormat& format) {
    const auto known = pictureFormat(raw.format);
    if (!known) {
        return refusal(
            "--format",
            fmt::format("\"{}\" is not a format; there are png, exr, jpg, svg, eps and pdf", raw.format));
    }
    format = *known;
    return success();
}

Status checkPage(RawOptions& raw, const cli::Command& app) {
    auto& page = raw.options.page;
    page.set_format(pageFormat(raw.options.format));
    const bool asked = app.count("--page") + app.count("--margin") + app.count("--dot") > 0 || raw.plotter;
    if (page.format() == proto::Page::FORMAT_UNSPECIFIED) {
        if (asked) return refusal("--format", "--page, --margin, --dot and --plotter need svg, eps or pdf");
        return success();
    }
    const auto cross = raw.page.find('x');
    if (!raw.page.empty()) {
        const auto width = cli::parseNumber(raw.page.substr(0, cross));
        const auto height = cross == std::string::npos ? width : cli::parseNumber(raw.page.substr(cross + 1));
        if (cross == std::string::npos || !width || !height) {
            return refusal("--page", fmt::format("\"{}\" is not WIDTHxHEIGHT in mm", raw.page));
        }
        page.set_width(*width);
        page.set_height(*height);
    }
    page.set_margin(raw.margin);
    page.set_dot(raw.dot);
    page.set_plotter(raw.plotter);
    const auto checked = parsePage(page);
    if (!checked.ok()) return refusal("--" + checked.error().where, checked.error().message);
    return success();
}

Status check(RawOptions& raw, const cli::Command& app) {
    MOTE_RETURN_IF_ERROR(checkFormat(raw, raw.options.format));
    MOTE_RETURN_IF_ERROR(checkPage(raw, app));
    if (!raw.video.empty() || app.count("--fps") > 0) {
        return refusal("--video",
                       "videos are not in this version; write pictures and join them with another program");
    }
    for (const auto& root : raw.options.roots) {
        const auto equals = root.find('=');
        if (equals == 0 || equals == std::string::npos || equals + 1 == root.size()) {
            return refusal("--spawn", fmt::format("\"{}\" is not NAME=DIR", root));
        }
    }
    if (!raw.device.empty() && raw.options.roots.empty()) {
        return refusal("--device", "chooses the device of a private server and needs --spawn");
    }
    return success();
}

}  // namespace

std::variant<FramesOptions, int> parseFramesOptions(int argc, const char* const* argv) {
    RawOptions raw;
    const cli::Program program("mote-frames renders the views of a script to picture files.", "mote-frames");
    const auto app = program.command();
    declare(app, raw);
    if (const auto end = program.parse(argc, argv, [&] { return check(raw, app); })) return *end;
    if (!raw.connect.empty()) raw.options.connect = raw.connect;
    if (!raw.device.empty()) raw.options.device = raw.device;
    return std::move(raw.options);
}

}  // namespace mote::client
