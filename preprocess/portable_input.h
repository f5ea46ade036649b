// SPDX-License-Identifier: GPL-3.0-or-later
//
// How a dataset's manifest names the input that it was made of. A function without state.
#pragma once

#include <filesystem>
#include <string>
#include <system_error>

namespace mote::prep {

/// The input as seen from the folder that holds the dataset `output`, so that a manifest does not depend on
/// where or how it was made.
inline std::string portableInput(const std::filesystem::path& input, const std::filesystem::path& output) {
    namespace fs = std::filesystem;
    std::error_code code;
    const auto folder = fs::weakly_canonical(fs::absolute(output, code).parent_path(), code);
    return fs::weakly_canonical(fs::absolute(input, code), code).lexically_relative(folder).string();
}

}  // namespace mote::prep
