// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/film/film_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "protocol/base/check.h"
#include "protocol/scene/film/check_script.h"

namespace mote {
namespace {

constexpr std::uint32_t mostQuality = 63;  // the worst that a codec knows
constexpr std::uint32_t mostSubframes = 64;

/// The name of a format, and the ending of its files.
struct Format {
    std::string_view name, ending;
};
constexpr std::array formats{Format{"", "png"}, Format{"png", "png"}, Format{"png16", "png"},
                             Format{"exr", "exr"}, Format{"jpg", "jpg"}};
constexpr std::array<std::string_view, 4> videos{"", "mp4", "webm", "gif"};
constexpr std::array<std::string_view, 3> chromas{"", "full", "halved"};
constexpr std::array<std::uint32_t, 5> sampleCounts{0, 1, 4, 9, 16};

}  // namespace

Status checkFilmJob(const proto::FilmJob& job) {
    if (!job.has_script()) return invalid("script", "is missing");
    MOTE_RETURN_IF_ERROR(checkScript(job.script()), "script");
    if (std::ranges::find(formats, job.format(), &Format::name) == formats.end())
        return invalid("format", "must be png, png16, exr or jpg");
    if (std::ranges::find(videos, job.video()) == videos.end())
        return invalid("video", "must be mp4, webm or gif, or be left out");
    if (std::ranges::find(chromas, job.chroma()) == chromas.end())
        return invalid("chroma", "must be full or halved");
    if (job.quality() > mostQuality) return invalid("quality", fmt::format("must be 0 to {}", mostQuality));
    if (std::ranges::find(sampleCounts, job.samples()) == sampleCounts.end())
        return invalid("samples", "must be 1, 4, 9 or 16");
    MOTE_RETURN_IF_ERROR(checkRange(job.shutter_degrees(), 0.0, 360.0, "shutterDegrees"));
    if (job.subframes() > mostSubframes)
        return invalid("subframes", fmt::format("must be at most {}", mostSubframes));
    return success();
}

std::string pictureName(std::uint64_t frame, std::string_view ending) {
    return fmt::format("frame-{:06}.{}", frame, ending);
}

std::string filmPictureName(const proto::FilmJob& job, std::uint32_t frame) {
    const auto* const format = std::ranges::find(formats, job.format(), &Format::name);
    return pictureName(frame, format != formats.end() ? format->ending : "png");
}

std::string filmVideoName(const proto::FilmJob& job) {
    return job.video().empty() ? std::string() : "film." + job.video();
}

}  // namespace mote
