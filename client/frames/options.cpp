// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "protocol/scene/page.h"

namespace mote::client {
namespace {

constexpr int wrongUsage = 2;

/// What the command line says before it is checked.
struct RawOptions {
    FramesOptions options;
    std::string connect, device, format = "png", video;
    double fps = 30.0;
    std::string page;
    double margin = 0.0, dot = 0.0;  // mm
    bool plotter = false;
};

void declare(CLI::App& app, RawOptions& raw) {
    app.footer(
        "Pictures are DIR/frame-000000.EXT and so on, each complete when it appears.\n\n"
        "Examples:\n"
        "  mote-frames views.json --connect ~/.mote/connection.json --out pictures\n"
        "  mote-frames views.json --spawn data=/scratch/plots --device egl --out pictures --format exr\n"
        "  mote-frames views.json --connect c.json --out pictures --resume --json > frames.jsonl\n"
        "  mote-frames dots.json --connect c.json --out prints --format pdf --page 210x297 --margin 15 --dot "
        "0.3");
    app.add_option("SCRIPT", raw.options.script, "Script of views (JSON), one picture each")->required();
    auto* server = app.add_option_group("server", "Which server draws (exactly one of these)");
    server->add_option("--connect", raw.connect, "Connection file of a running server");
    server
        ->add_option("--spawn", raw.options.roots,
                     "Start a private server with this root, NAME=DIR; repeatable")
        ->expected(1)
        ->take_all()
        ->allow_extra_args(false);
    server->require_option(1);
    app.add_option("--device", raw.device, "Device of the private server: auto, egl or cpu");
    app.add_option("--out", raw.options.out, "Folder of the pictures; made if it is not there")->required();
    app.add_option("--format", raw.format,
                   "png (8 bits, sRGB), exr (half floats, linear), jpg (quality 95), or dots as shapes: "
                   "svg, eps or pdf")
        ->capture_default_str();
    auto* sheet = app.add_option_group("sheet", "Of svg, eps and pdf");
    sheet->add_option("--page", raw.page, "Size in mm; 96 pixels an inch unless given")
        ->type_name("WIDTHxHEIGHT");
    sheet->add_option("--margin", raw.margin, "On each side, mm")->type_name("MM");
    sheet->add_option("--dot", raw.dot, "Diameter of the largest dots, mm; as in the picture unless given")
        ->type_name("MM");
    sheet->add_flag("--plotter", raw.plotter, "Each dot a tiny stroke, in the order of a short tour");
    app.add_option("--video", raw.video, "Not in this version");
    app.add_option("--fps", raw.fps, "Not in this version");
    app.add_flag("--resume", raw.options.resume, "Keep pictures that are whole and show the same view");
    app.add_flag("--json", raw.options.json, "One line of JSON a picture on stdout");
    app.add_flag("--quiet", raw.options.quiet, "No progress on stderr");
}

void refuse(const std::string& option, const std::string& why) {
    throw CLI::ValidationError(option, why);
}

void checkFormat(const RawOptions& raw, PictureFormat& format) {
    const auto known = pictureFormat(raw.format);
    if (known) {
        format = *known;
        return;
    }
    refuse("--format",
           fmt::format("\"{}\" is not a format; there are png, exr, jpg, svg, eps and pdf", raw.format));
}

void checkPage(RawOptions& raw, const CLI::App& app) {
    auto& page = raw.options.page;
    page.set_format(pageFormat(raw.options.format));
    const bool asked = app.count("--page") + app.count("--margin") + app.count("--dot") > 0 || raw.plotter;
    if (page.format() == proto::Page::FORMAT_UNSPECIFIED) {
        if (asked) refuse("--format", "--page, --margin, --dot and --plotter need svg, eps or pdf");
        return;
    }
    const auto cross = raw.page.find('x');
    double width = 0.0, height = 0.0;
    if (!raw.page.empty() &&
        (cross == std::string::npos || !CLI::detail::lexical_cast(raw.page.substr(0, cross), width) ||
         !CLI::detail::lexical_cast(raw.page.substr(cross + 1), height))) {
        refuse("--page", fmt::format("\"{}\" is not WIDTHxHEIGHT in mm", raw.page));
    }
    page.set_width(width);
    page.set_height(height);
    page.set_margin(raw.margin);
    page.set_dot(raw.dot);
    page.set_plotter(raw.plotter);
    const auto checked = parsePage(page);
    if (!checked.ok()) refuse("--" + checked.error().where, checked.error().message);
}

void check(RawOptions& raw, const CLI::App& app) {
    checkFormat(raw, raw.options.format);
    checkPage(raw, app);
    if (!raw.video.empty() || app.count("--fps") > 0) {
        refuse("--video",
               "videos are not in this version; write pictures and join them with another program");
    }
    for (const auto& root : raw.options.roots) {
        const auto equals = root.find('=');
        if (equals == 0 || equals == std::string::npos || equals + 1 == root.size()) {
            refuse("--spawn", fmt::format("\"{}\" is not NAME=DIR", root));
        }
    }
    if (!raw.device.empty() && raw.options.roots.empty()) {
        refuse("--device", "chooses the device of a private server and needs --spawn");
    }
}

}  // namespace

std::variant<FramesOptions, int> parseFramesOptions(int argc, const char* const* argv) {
    RawOptions raw;
    CLI::App app("mote-frames renders the views of a script to picture files.", "mote-frames");
    declare(app, raw);
    try {
        app.parse(argc, argv);
        check(raw, app);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : wrongUsage;
    }
    if (!raw.connect.empty()) raw.options.connect = raw.connect;
    if (!raw.device.empty()) raw.options.device = raw.device;
    return std::move(raw.options);
}

}  // namespace mote::client
