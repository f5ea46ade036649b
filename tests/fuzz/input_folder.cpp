// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/input_folder.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <system_error>

#include "tests/fuzz/require.h"

namespace mote::test {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t mostFiles = 32, mostNameBytes = 100;

}  // namespace

InputFolder::InputFolder() {
    std::error_code code;
    const bool memory = fs::is_directory("/dev/shm", code);
    std::string name = (memory ? fs::path("/dev/shm") : fs::temp_directory_path()) / "mote-fuzz-XXXXXX";
    require(mkdtemp(name.data()) != nullptr);
    path_ = name;
}

InputFolder::~InputFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
}

void InputFolder::write(const std::string& name, std::string_view bytes) const {
    std::ofstream(path_ / name, std::ios::binary) << bytes;
}

bool isPlainName(std::string_view name) {
    return !name.empty() && name.size() < mostNameBytes && name.front() != '.' &&
           name.find('/') == std::string_view::npos && name.find('\0') == std::string_view::npos;
}

std::map<std::string, std::string> filesOf(std::string_view input) {
    std::map<std::string, std::string> files;
    while (!input.empty() && files.size() < mostFiles) {
        const auto [line, rest] = firstLine(input);
        const auto blank = std::min(line.find(' '), line.size());
        const std::string name(line.substr(0, blank));
        const auto digits = line.substr(std::min(blank + 1, line.size()));
        std::size_t size = 0;
        std::from_chars(digits.data(), digits.data() + digits.size(), size);
        size = std::min(size, rest.size());
        if (isPlainName(name)) files[name] = rest.substr(0, size);
        input = rest.substr(size);
    }
    return files;
}

}  // namespace mote::test
