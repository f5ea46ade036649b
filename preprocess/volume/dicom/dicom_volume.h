// SPDX-License-Identifier: GPL-3.0-or-later
//
// Volumes of DICOM files: the pictures of a series in a folder, in a zip archive, or one by one. Called from
// one thread.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "preprocess/volume/dicom/dicom_series.h"
#include "preprocess/volume/dicom/dicom_stack.h"
#include "preprocess/volume/volume_parts.h"
#include "preprocess/volume/volume_source.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// What to look into, and for what.
struct DicomInput {
    std::vector<std::filesystem::path> paths;  ///< each as of dicomFiles
    std::string series;                        ///< as of chooseSeries
};

/// An input as it was looked at: its files, and the series that was chosen. Shared by all of its volumes.
struct DicomLook {
    DicomSet set;
    DicomStack stack;
};

/// `progress` is asked while files are looked at. Errors: those of dicomFiles, DicomSet::read, chooseSeries
/// and DicomStack::of.
Result<std::shared_ptr<const DicomLook>> lookAtDicom(const DicomInput& input, const Progress& progress);
/// Several pictures at each place are volumes: `field` is as of chooseParts. Errors: those of checkPixels and
/// chooseParts.
Result<std::unique_ptr<VolumeSource>> openDicom(const std::shared_ptr<const DicomLook>& look,
                                                const std::string& field);
VolumeParts partsOfDicom(const DicomLook& look);

/// Whether the paths are files of one picture each, which only together are a volume.
bool areDicomSlices(const std::vector<std::filesystem::path>& paths);

}  // namespace mote::prep
