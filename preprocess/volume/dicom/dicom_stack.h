// SPDX-License-Identifier: GPL-3.0-or-later
//
// DicomStack: the pictures of a series as slices of one volume or of several at one place, and the grid on
// which they lie: by where they are in the patient, never by names or numbers of files where these are said.
// A value.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "preprocess/volume/dicom/dicom_series.h"
#include "protocol/scene/error.h"

namespace mote::prep {

struct DicomStack {
    std::vector<std::vector<DicomPicture>> volumes;  ///< each with its slices in order
    std::vector<std::optional<double>> times;        ///< of each volume, s, from the first one on
    glm::dmat3 axes{1.0};                            ///< one voxel's step along each axis, mm, LPS
    glm::dvec3 origin{0.0};                          ///< of the first voxel's centre
    bool placed = false;                             ///< the file says how the patient lies
    bool sized = false;                              ///< and how large a pixel is
    std::vector<std::string> notes;

    /// Errors: corrupt (slices that are missing, there twice or unevenly far apart; directions that are
    /// none), unsupported (a single picture).
    static Result<DicomStack> of(const DicomSet& set, const DicomSeries& series);
};

}  // namespace mote::prep
