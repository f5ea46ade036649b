// SPDX-License-Identifier: GPL-3.0-or-later
//
// MetaImage volumes (itk.org/Wiki/ITK/MetaIO/Documentation): .mha, or .mhd with data beside it, zlib or not,
// or text. Called from one thread.
#pragma once

#include <filesystem>

#include "preprocess/volume/volume_source.h"

namespace mote::prep {

/// `path` is the file with the header; it may be gzipped. Errors: corrupt, unsupported (vectors, other than
/// three axes), permissionDenied (data in another folder), those of fileStream.
Result<std::unique_ptr<VolumeSource>> openMetaImage(const std::filesystem::path& path);

}  // namespace mote::prep
