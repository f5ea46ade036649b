// SPDX-License-Identifier: GPL-3.0-or-later
//
// Texts of variable length, read from a file's global heap by our own code. HDF5's own (H5HG) believes the
// heap: in version 1.10 a changed index or size there makes it read anywhere in memory, or loop without end.
// Functions without state; the HDF5 library keeps one registration of theirs.
#pragma once

#include <hdf5.h>

#include <string>

#include "protocol/scene/error.h"

namespace mote::prep {

/// The first element of an attribute whose type is text of variable length, at most 64 KiB of it. Errors, at
/// `where`: corrupt.
Result<std::string> readVariableText(hid_t attribute, std::size_t elements, const std::string& where);

}  // namespace mote::prep
