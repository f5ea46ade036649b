// SPDX-License-Identifier: GPL-3.0-or-later
//
// PathLength: how far a camera has come on its path, and where it is after so far: what a film of constant
// speed goes by. The camera moves as far as its eye or its target, whichever moves more. Refers to its path;
// safe on any number of threads.
#pragma once

#include <cstddef>
#include <vector>

#include "protocol/scene/film/camera_path.h"

namespace mote {

class PathLength {
  public:
    struct Place {
        std::size_t way;
        double share;  ///< of the way, 0 to 1
    };

    /// Of a path without jumps, which outlives it.
    explicit PathLength(const CameraPath& path);

    double total() const { return lengths_.back(); }  ///< world units
    double ofWay(std::size_t way) const;
    /// Where the camera is after a length from 0 to total(), > 0.
    Place at(double length) const;

  private:
    double speed(std::size_t way, double share) const;
    double between(std::size_t way, double from, double to) const;
    double shareAfter(std::size_t way, double from, double to, double length) const;

    const CameraPath& path_;
    std::size_t cells_;            ///< of a way, of even shares
    std::vector<double> lengths_;  ///< from the beginning to each cell's, and to the end
};

}  // namespace mote
