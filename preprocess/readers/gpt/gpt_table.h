// SPDX-License-Identifier: GPL-3.0-or-later
//
// Outputs of GPT (General Particle Tracer) as tables: of its binary files (GDF) and of text. Functions
// without state.
#pragma once

#include <filesystem>
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

/// The groups of a GDF file that hold particles. Errors: corrupt, resourceExhausted, those of ByteSource.
Result<std::vector<GptBlock>> readGdf(const std::filesystem::path& path, HeldNumbers& held);

/// The blocks of a text: lines "time 1e-9", lines of names, rows. The same errors.
Result<std::vector<GptBlock>> readGptText(const std::filesystem::path& path, HeldNumbers& held);

/// GPT's names as a table's: Bx, GBx, G, m [kg], q of one particle, nmacro. `mass` in eV/c^2, 0: that of the
/// first row, else the electron's, with a note.
HeldTable gptTable(GptBlock block, double mass, const std::string& name);

/// Whether a line names GPT's columns: x and at least two of Bx, By, Bz, GBx, GBy, GBz, G, nmacro.
bool namesGptColumns(std::string_view line);

}  // namespace mote::prep
