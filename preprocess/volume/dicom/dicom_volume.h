// SPDX-License-Identifier: GPL-3.0-or-later
//
// Volumes of DICOM files: the pictures of a series in a folder, in a zip archive, or one by one. Called from
// one thread.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "preprocess/volume/volume_parts.h"
#include "preprocess/volume/volume_source.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// What to look into, and for what.
struct DicomInput {
    std::vector<std::filesystem::path> paths;  ///< each as of dicomFiles
    std::string series;                        ///< as of chooseSeries
};

/// Several pictures at each place are volumes: `field` is as of chooseParts. `progress` is asked while files
/// are looked at. Errors: those of dicomFiles, DicomSet::read, chooseSeries, DicomStack::of, checkPixels and
/// chooseParts.
Result<std::unique_ptr<VolumeSource>> openDicom(const DicomInput& input, const std::string& field,
                                                const Progress& progress);
Result<VolumeParts> partsOfDicom(const DicomInput& input, const Progress& progress);

/// Whether the paths are files of one picture each, which only together are a volume.
bool areDicomSlices(const std::vector<std::filesystem::path>& paths);

}  // namespace mote::prep
