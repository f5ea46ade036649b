// SPDX-License-Identifier: GPL-3.0-or-later
//
// DicomSet: the DICOM files of an input, read but for their pixels. DicomSeries: the pictures among them that
// belong together, being of one series, size and orientation. Values; reading asks one thread at a time.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/volume/dicom/dicom_files.h"
#include "preprocess/volume/dicom/dicom_header.h"
#include "protocol/scene/error.h"

namespace mote::prep {

struct DicomSet {
    static constexpr std::size_t mostPictures = 1u << 18;

    std::string name;  ///< of the input, for messages
    std::vector<DicomFile> files;
    std::vector<DicomHeader> headers;  ///< of each file, all with pixels
    std::vector<std::string> notes;    ///< what was left out

    /// Files that are no pictures, cannot be read or are there twice are left out. Errors: unsupported (no
    /// pictures at all, or one that is of no kind that is read), resourceExhausted, cancelled, the first
    /// one's where none can be read.
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

}  // namespace mote::prep
