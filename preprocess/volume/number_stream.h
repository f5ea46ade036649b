// SPDX-License-Identifier: GPL-3.0-or-later
//
// Numbers that are written as text, as a stream of doubles. One owner, one thread at a time.
#pragma once

#include "preprocess/volume/byte_stream.h"

namespace mote::prep {

/// Eight bytes, the machine's own double, for each number of `text`; between them stand blanks, line ends or
/// commas. They end with the text or, in XML, at a '<'. Reading: corrupt where a word is no number.
ByteStreamPtr numberStream(ByteStreamPtr text);

}  // namespace mote::prep
