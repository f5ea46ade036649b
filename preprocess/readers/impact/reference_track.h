// SPDX-License-Identifier: GPL-3.0-or-later
//
// ReferenceTrack: fort.18 of an IMPACT-Z run, the reference particle along the machine. A value.
#pragma once

#include <filesystem>
#include <vector>

#include "protocol/scene/error.h"

namespace mote::prep {

struct ReferenceTrack {
    struct Point {
        double path = 0.0;   ///< m
        double phase = 0.0;  ///< rad, of the scaling frequency: angular frequency times time
        double gamma = 1.0;  ///< total over rest energy
    };
    std::vector<Point> points;  ///< by path, at least one

    /// The track at a path length, between its points by straight lines; of points at one place the last.
    Point at(double path) const;

    /// Reads the file (columns path, phase, gamma, ...). Where the path falls back, an earlier run stands
    /// before and is left out. Errors: corrupt (with the line), those of LineReader.
    static Result<ReferenceTrack> read(const std::filesystem::path& path);
};

}  // namespace mote::prep
