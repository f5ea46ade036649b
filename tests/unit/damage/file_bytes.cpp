// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/damage/file_bytes.h"

#include <fstream>
#include <sstream>
#include <utility>

namespace mote::test {

std::string bytesOfFile(const std::filesystem::path& path) {
    std::ostringstream bytes;
    bytes << std::ifstream(path, std::ios::binary).rdbuf();
    return std::move(bytes).str();
}

void writeFile(const std::filesystem::path& path, std::string_view bytes) {
    std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

}  // namespace mote::test
