// SPDX-License-Identifier: GPL-3.0-or-later
//
// DicomFiles: where the files of a patient lie: in a folder and those below it, in a zip archive, or one by
// one. Found by their content: names of such files may be anything. Called from one thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/readers/npy/zip_directory.h"
#include "preprocess/volume/byte_stream.h"
#include "protocol/base/error.h"

namespace mote::prep {

/// A file, or an entry of an archive.
struct DicomFile {
    std::filesystem::path path;
    std::optional<ZipEntry> entry = {};

    std::string name() const;  ///< without its folder, which often is a patient's name
    /// Errors: those of fileStream and ArrayBytes.
    Result<ByteStreamPtr> open() const;
};

/// The DICOM files of an input, in the order of their names: all of a folder and of those below it (at most 8
/// deep, hidden ones left out, no links to folders followed), of a zip archive, those of a pattern
/// ("IM*"), or the file itself. `most`:
/// no more than that, to see whether there are any. Errors: notFound, resourceExhausted (more than 2^20
/// files, or 65536 in an archive), permissionDenied, cancelled, those of readZipDirectory.
Result<std::vector<DicomFile>> dicomFiles(const std::filesystem::path& input, const Progress& progress,
                                          std::optional<std::size_t> most = std::nullopt);

/// Whether there is any.
Result<bool> holdsDicom(const std::filesystem::path& input, const Progress& progress);

}  // namespace mote::prep
