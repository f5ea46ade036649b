// SPDX-License-Identifier: GPL-3.0-or-later
//
// Film jobs: what one may ask for, and what the files that it makes are called. Pure functions.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote {

/// Errors: invalidArgument, with the path of the field within the job.
Status checkFilmJob(const proto::FilmJob& job);

/// The file of a film's picture, "frame-000012.png": `ending` is "png".
std::string pictureName(std::uint64_t frame, std::string_view ending);
/// The same, by what the job asks for. The job is a checked one, here and below.
std::string filmPictureName(const proto::FilmJob& job, std::uint32_t frame);
/// "film.mp4"; empty where no video is asked for.
std::string filmVideoName(const proto::FilmJob& job);

}  // namespace mote
