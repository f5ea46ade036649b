// SPDX-License-Identifier: GPL-3.0-or-later
//
// The file beside a header that holds its numbers (NRRD, MetaImage). A header may name what lies in its own
// folder or below, and nothing else: who wrote it must not choose which files a job reads. Functions without
// state.
#pragma once

#include <filesystem>
#include <string_view>

#include "preprocess/volume/source/byte_stream.h"

namespace mote::prep {

/// Opens `name`, as the header at `header` has it. Errors: permissionDenied (another folder), those of
/// fileStream.
Result<ByteStreamPtr> dataFileStream(const std::filesystem::path& header, std::string_view name);

}  // namespace mote::prep
