// SPDX-License-Identifier: GPL-3.0-or-later
//
// Volumes of DICOM files: the pictures of a series in a folder, in a zip archive, or one by one. Called from
// one thread.
//
// DicomStack: the pictures of a series as slices of one volume or of several at one place, and the grid on
// which they lie: by where they are in the patient, never by names or numbers of files where these are said.
// A value.
//
// DicomSet: the DICOM files of an input, read but for their pixels. DicomSeries: the pictures among them that
// belong together, being of one series, size and orientation. Values; reading asks one thread at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/volume/dicom/dicom_files.h"
#include "preprocess/volume/dicom/dicom_header.h"
#include "preprocess/volume/volume_shape.h"
#include "preprocess/volume/volume_source.h"
#include "protocol/base/error.h"

namespace mote::prep {

struct DicomSet {
    static constexpr std::size_t mostPictures = 1u << 18;

    std::string name;  ///< of the input, for messages
    std::vector<DicomFile> files;
    std::vector<DicomHeader> headers;  ///< of each file, all with pixels
    std::vector<std::string> notes;    ///< what was left out

    /// Files that are no pictures, cannot be read or are there twice are left out. Errors: unsupported (no
    /// pictures at all, or one that is of no kind that is read), resourceExhausted, cancelled, the first
    /// one's if none can be read.
    static Result<DicomSet> read(std::string name, std::vector<DicomFile> files, const Progress& progress);
};

struct DicomPicture {
    std::size_t file = 0;     ///< index in the set
    std::uint32_t frame = 0;  ///< of the file
    DicomFrame at;
};

struct DicomSeries {
    std::string uid, modality;
    std::optional<double> number;  ///< as the scanner counts
    std::string label;             ///< what it is chosen by
    std::uint32_t columns = 0, rows = 0;
    std::vector<DicomPicture> pictures;
};

/// The series of the label or UID `wanted`; "": the only one. Errors: unsupported (there are several and none
/// was asked for: a sentence that lists them, with nothing of whom they show), notFound.
Result<DicomSeries> chooseSeries(const DicomSet& set, std::string_view wanted);

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
