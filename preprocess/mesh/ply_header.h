// SPDX-License-Identifier: GPL-3.0-or-later
//
// The header of a PLY file: its elements and their properties, in the file's order. A value and the function
// that reads it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/readers/text/stored_number.h"
#include "protocol/scene/error.h"

namespace mote::prep {

enum class PlyEncoding { ascii, littleEndian, bigEndian };

struct PlyProperty {
    std::string name;
    StoredNumber type = StoredNumber::float32;  ///< of the value, or of each in the list
    std::optional<StoredNumber> countType;      ///< of a list; an integer
};

struct PlyElement {
    std::string name;
    std::uint64_t count = 0;  ///< no more than the bytes behind the header, where it has a property
    std::vector<PlyProperty> properties;
};

struct PlyHeader {
    PlyEncoding encoding = PlyEncoding::ascii;
    std::vector<PlyElement> elements;
    std::size_t bytes = 0;    ///< of the header: where the values begin
    std::uint64_t lines = 0;  ///< of the header
};

/// Errors: corrupt with the line, unsupported (an encoding that we do not know).
Result<PlyHeader> readPlyHeader(std::string_view bytes, const std::string& name);

}  // namespace mote::prep
