// SPDX-License-Identifier: GPL-3.0-or-later
//
// NIfTI-1 and NIfTI-2 volumes (nifti.nimh.nih.gov): .nii, or .hdr with the numbers in the .img file beside
// it. Called from one thread.
#pragma once

#include <filesystem>

#include "preprocess/volume/volume_source.h"

namespace mote::prep {

/// Each file may be gzipped. Errors: corrupt, unsupported (vectors, several times), notFound (no .img file),
/// those of fileStream.
Result<std::unique_ptr<VolumeSource>> openNifti(const std::filesystem::path& path);

}  // namespace mote::prep
