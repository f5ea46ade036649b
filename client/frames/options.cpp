// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

namespace mote::client {
namespace {

constexpr int wrongUsage = 2;

/// What the command line says before it is checked.
struct RawOptions {
    FramesOptions options;
    std::string connect, device, format = "png", video;
    double fps = 30.0;
};

void declare(CLI::App& app, RawOptions& raw) {
    app.footer(
        "Pictures are DIR/frame-000000.EXT and so on, each complete when it appears.\n\n"
        "Examples:\n"
        "  mote-frames views.json --connect ~/.mote/connection.json --out pictures\n"
        "  mote-frames views.json --spawn data=/scratch/plots --device egl --out pictures --format exr\n"
        "  mote-frames views.json --connect c.json --out pictures --resume --json > frames.jsonl");
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
                   "png (8 bits, sRGB), exr (half floats, linear) or jpg (quality 95)")
        ->capture_default_str();
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
    const bool vectorFormat = raw.format == "svg" || raw.format == "eps" || raw.format == "pdf";
    if (vectorFormat) refuse("--format", raw.format + " is not in this version; it writes png, exr and jpg");
    refuse("--format", fmt::format("\"{}\" is not a format; there are png, exr and jpg", raw.format));
}

void check(RawOptions& raw, const CLI::App& app) {
    checkFormat(raw, raw.options.format);
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
