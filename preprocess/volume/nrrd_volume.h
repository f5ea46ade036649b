// SPDX-License-Identifier: GPL-3.0-or-later
//
// NRRD volumes, versions 1 to 5 (teem.sourceforge.net/nrrd/format.html): raw, gzip and text encoding, data in
// the same file or beside it. Called from one thread.
#pragma once

#include <filesystem>

#include "preprocess/volume/volume_source.h"

namespace mote::prep {

/// `path` is the file with the header; it may be gzipped. Errors: corrupt, unsupported (another encoding,
/// vectors, not three axes), those of fileStream.
Result<std::unique_ptr<VolumeSource>> openNrrd(const std::filesystem::path& path);

}  // namespace mote::prep
