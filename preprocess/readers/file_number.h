// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the readers of series share: the number in a file's name, the order of files, and the check of a read.
// Functions without state.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "preprocess/readers/particle_source.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// The last number in a file's name, its endings left out: 101 of "fort.101.txt.gz", 3 of "beam_0003.csv".
std::optional<std::int64_t> fileNumber(const std::filesystem::path& path);

/// Files by their numbers where all have different ones, else as they are given.
std::vector<std::filesystem::path> inOrder(std::vector<std::filesystem::path> files);

/// Whether rows [begin, begin + count) of a step may be read at once. Error: invalidArgument.
Status checkRange(const std::vector<SourceStep>& steps, std::size_t step, std::uint64_t begin,
                  std::size_t count);

}  // namespace mote::prep
