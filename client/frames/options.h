// SPDX-License-Identifier: GPL-3.0-or-later
//
// The command line of mote-frames. A value.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "client/frames/exposure.h"
#include "client/frames/picture_file.h"
#include "client/frames/video/video_settings.h"

namespace mote::client {

/// What is asked of mote-frames.
enum class FramesTask {
    draw,      ///< a script, here
    detach,    ///< leave a script with the server, as a job
    fetch,     ///< what such a job made
    job,       ///< be such a job: for servers
    listJobs,  ///< what jobs a server has
    follow,    ///< a job, until it ends
    cancel,
    retry,  ///< what failed or was cancelled, as a new job
};

/// Pixels.
struct PictureSize {
    std::uint32_t width = 0, height = 0;
};

struct FramesOptions {
    FramesTask task = FramesTask::draw;
    std::filesystem::path script;                ///< of a job: the file of its request
    std::vector<std::filesystem::path> connect;  ///< running servers' connection files, or
    std::vector<std::string> roots;              ///< "NAME=DIR" of the private servers to start
    std::optional<std::string> device;           ///< of the private servers
    unsigned threads = 0;                        ///< of all private servers together; 0: all cores
    unsigned jobs = 1;                           ///< private servers
    std::chrono::seconds patience{0};            ///< with a server that sends no pictures; 0: without end
    std::filesystem::path out;                   ///< folder of the pictures; empty: there are none
    PictureFormat format = PictureFormat::png;
    std::optional<PictureSize> size;  ///< of every view, in place of its own
    bool annotate = false;            ///< views that do not say so have axes, labels and bars
    proto::Page page;                 ///< of documents
    ExposureSettings exposure;
    std::filesystem::path video;        ///< file of the video; empty: there is none
    std::optional<unsigned> crf;        ///< its quality
    std::optional<VideoChroma> chroma;  ///< likewise; absent: full, of a detached film halved
    std::optional<double> fps;          ///< frames a second, in place of the script's
    bool keepFrames = false;            ///< pictures beside the video
    bool resume = false;                ///< keep frames that are whole and show the same
    bool force = false;                 ///< a video that is there is replaced
    bool json = false;                  ///< one JSON object a frame on stdout
    bool quiet = false;                 ///< no progress on stderr
    bool again = false;                 ///< detached although the server has the same film
    std::uint32_t jobTime = 0;          ///< s, of a run of the detached film; 0: the server's limit
    std::string jobId;                  ///< that is fetched, followed, cancelled or tried again
    int progressDescriptor = -1;        ///< of a job
};

/// The options, or the exit status after help (0) or wrong usage (2), which has been printed.
std::variant<FramesOptions, int> parseFramesOptions(int argc, const char* const* argv);

}  // namespace mote::client
