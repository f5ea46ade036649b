// SPDX-License-Identifier: GPL-3.0-or-later
//
// A file in an archive, or part of a file, as a ByteStream. One owner, one thread at a time.
#pragma once

#include "preprocess/readers/npy/array_bytes.h"
#include "preprocess/volume/byte_stream.h"

namespace mote::prep {

/// Its checksum, if it has one, is looked at where it is read in order to its end. Errors: those of
/// ArrayBytes::open; reading: those of ArrayBytes::read.
Result<ByteStreamPtr> archiveStream(const ArrayBytes::Part& part);

/// Reads all of a stream for its checksum, if only a part of it is needed, and goes back to its beginning.
/// Errors: those of reading.
Status checkWhole(ByteStream& stream);

}  // namespace mote::prep
