// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/file_number.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <set>
#include <string>

namespace mote::prep {
namespace {

constexpr std::size_t maxCount = std::size_t{1} << 22;

bool digit(char c) {
    return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

/// The name without endings that start with a letter: "fort.101.txt.gz" becomes "fort.101".
std::string withoutEndings(std::string name) {
    for (std::size_t dot = name.rfind('.'); dot != std::string::npos && dot > 0; dot = name.rfind('.')) {
        if (dot + 1 < name.size() && digit(name[dot + 1])) break;
        name.resize(dot);
    }
    return name;
}

}  // namespace

std::optional<std::int64_t> fileNumber(const std::filesystem::path& path) {
    const std::string name = withoutEndings(path.filename().string());
    std::size_t end = name.size();
    while (end > 0 && !digit(name[end - 1])) --end;
    std::size_t begin = end;
    while (begin > 0 && digit(name[begin - 1])) --begin;
    std::int64_t number = 0;
    const auto [last, code] = std::from_chars(name.data() + begin, name.data() + end, number);
    if (code != std::errc() || last != name.data() + end) return std::nullopt;
    return number;
}

std::vector<std::filesystem::path> inOrder(std::vector<std::filesystem::path> files) {
    std::set<std::int64_t> numbers;
    for (const auto& file : files) {
        if (const auto number = fileNumber(file)) numbers.insert(*number);
    }
    if (numbers.size() == files.size()) {
        std::sort(files.begin(), files.end(),
                  [](const auto& a, const auto& b) { return *fileNumber(a) < *fileNumber(b); });
    }
    return files;
}

Status checkRange(const std::vector<SourceStep>& steps, std::size_t step, std::uint64_t begin,
                  std::size_t count) {
    if (step >= steps.size()) return Error{ErrorCode::invalidArgument, "", "there is no such step"};
    const std::uint64_t rows = steps[step].particles;
    if (count > maxCount || begin > rows || count > rows - begin) {
        return Error{ErrorCode::invalidArgument, steps[step].file,
                     "rows that the step does not have, or too many at once, were asked for"};
    }
    return success();
}

}  // namespace mote::prep
