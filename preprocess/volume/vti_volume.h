// SPDX-License-Identifier: GPL-3.0-or-later
//
// VTK image files (.vti; docs.vtk.org, "XML File Formats"): values as text, in base64 or appended, compressed
// by zlib or not. Called from one thread.
#pragma once

#include <filesystem>
#include <string_view>

#include "preprocess/volume/volume_source.h"

namespace mote::prep {

/// The array `field`, as VtiHeader::parse chooses it. The file may be gzipped. Errors: corrupt, unsupported
/// (vectors, several pieces, another compressor), notFound (no such array), cancelled, those of fileStream.
Result<std::unique_ptr<VolumeSource>> openVti(const std::filesystem::path& path, std::string_view field,
                                              const Progress& progress);

}  // namespace mote::prep
