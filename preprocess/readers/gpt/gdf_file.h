// SPDX-License-Identifier: GPL-3.0-or-later
//
// Binary outputs of GPT (General Particle Tracer). Functions without state.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "preprocess/readers/table/held_source.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// A group of GPT's arrays, with its time or place.
struct GptBlock {
    std::optional<double> time;  ///< s
    std::vector<std::string> names;
    std::vector<std::vector<double>> values;
};

/// The groups of a GDF file that hold particles. Errors: corrupt, resourceExhausted, those of HeldFile::text.
Result<std::vector<GptBlock>> readGdf(const HeldFile& file);

}  // namespace mote::prep
