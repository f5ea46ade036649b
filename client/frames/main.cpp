// SPDX-License-Identifier: GPL-3.0-or-later

#include <cstdio>
#include <exception>
#include <utility>

#include "client/frames/draw_film.h"
#include "client/frames/job_commands.h"
#include "client/frames/options.h"
#include "client/frames/remote_film.h"
#include "client/shared/interrupt.h"
#include "client/shared/script.h"
#include "protocol/scene/complain.h"
#include "protocol/scene/film/check_script.h"
#include "protocol/scene/film/sized_script.h"

namespace mote::client {
namespace {

constexpr int failure = 1;
constexpr int killedBy = 128;  // and the signal's number, as shells say it

Status runScript(const FramesOptions& options, const Interrupt& interrupt) {
    const auto size = options.size.value_or(PictureSize{});
    MOTE_ASSIGN_OR_RETURN(auto script, readScript(options.script, size.width, size.height));
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

int run(int argc, const char* const* argv) {
    const Interrupt interrupt;
    const auto parsed = parseFramesOptions(argc, argv);
    if (const int* status = std::get_if<int>(&parsed)) return *status;
    const auto done = runTask(std::get<FramesOptions>(parsed), interrupt);
    if (done.ok()) return 0;
    complain("mote-frames", done.error().toString());
    return interrupt.requested() ? killedBy + interrupt.signal() : failure;
}

}  // namespace
}  // namespace mote::client

int main(int argc, char** argv) {
    try {
        return mote::client::run(argc, argv);
    } catch (const std::exception& error) {
        mote::complainAtEnd("mote-frames", error);
        return 1;
    }
}
