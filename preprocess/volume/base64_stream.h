// SPDX-License-Identifier: GPL-3.0-or-later
//
// Bytes that are written as text in base64 (RFC 4648). One owner, one thread at a time.
#pragma once

#include "preprocess/volume/byte_stream.h"

namespace mote::prep {

/// The bytes that `text` stands for, to its end or to a '<'; blanks and line ends are stepped over. Groups
/// that end with '=' may stand anywhere: VTK writes several texts one after the other. Reading: corrupt where
/// a character means nothing.
ByteStreamPtr base64Stream(ByteStreamPtr text);

}  // namespace mote::prep
