// SPDX-License-Identifier: GPL-3.0-or-later
//
// Streams that NRRD alone wraps its numbers in: bzip2, and hexadecimal text. Each owns the one it reads; one
// thread at a time.
#pragma once

#include "preprocess/volume/byte_stream.h"

namespace mote::prep {

/// What comes out of bzip2 data, several of them one after the other; what follows and is none is left alone.
/// Errors: internal; reading: corrupt (damaged or cut data).
Result<ByteStreamPtr> bzip2Stream(ByteStreamPtr compressed);

/// A byte for every two digits of `text`; blanks and line ends are stepped over. Reading: corrupt where
/// something else stands, or a digit alone.
ByteStreamPtr hexStream(ByteStreamPtr text);

}  // namespace mote::prep
