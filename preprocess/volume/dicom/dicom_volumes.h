// SPDX-License-Identifier: GPL-3.0-or-later
//
// Several pictures at each place of a series (times, echoes, weights of diffusion) as volumes, one of each
// place: told apart by what differs. Pure functions.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "preprocess/volume/dicom/dicom_series.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// The pictures that lie at one place.
using DicomPlace = std::vector<DicomPicture>;

struct DicomVolumes {
    std::vector<std::vector<DicomPicture>> volumes;
    std::vector<std::optional<double>> times;  ///< of each volume, s, from the first one on
    std::string note;                          ///< by what they were told apart; "" where there is one
};

/// Errors: corrupt (places with more pictures than others).
Result<DicomVolumes> tellApart(const DicomSet& set, std::vector<DicomPlace> places);

}  // namespace mote::prep
