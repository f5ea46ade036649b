// SPDX-License-Identifier: GPL-3.0-or-later
//
// Attributes of foreign HDF5 objects as numbers and text, in every form that writers use: scalars, arrays of
// one element, integers, floats and enumerations of any size, strings of fixed and of variable length. No
// state.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "preprocess/readers/hdf5/h5_file.h"
#include "protocol/base/error.h"

namespace mote::prep {

/// All elements (at most 4096). Nothing where the attribute is absent. Errors: corrupt, unsupported (no
/// number).
Result<std::optional<std::vector<double>>> numbersAttribute(const H5Object& object, const char* name);

/// The first element. The same errors; an attribute without elements is corrupt.
Result<std::optional<double>> numberAttribute(const H5Object& object, const char* name);

/// The first string, without padding. Errors: corrupt, unsupported (no text, more than 64 KiB).
Result<std::optional<std::string>> textAttribute(const H5Object& object, const char* name);

/// All strings, at most 16. The same errors.
Result<std::optional<std::vector<std::string>>> textsAttribute(const H5Object& object, const char* name);

}  // namespace mote::prep
