// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/volume_formats.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <numeric>
#include <optional>
#include <string>
#include <system_error>

#include "preprocess/readers/text/number.h"
#include "preprocess/volume/volume_shape.h"
#include "protocol/base/utf8.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

bool isDigit(char c) {
    return c >= '0' && c <= '9';
}

/// The digits at the beginning of `text`, which loses them, without zeros in front.
std::string_view takeNumber(std::string_view& text) {
    std::size_t end = 0;
    while (end < text.size() && isDigit(text[end])) ++end;
    std::string_view number = text.substr(0, end);
    text.remove_prefix(end);
    while (number.starts_with('0')) number.remove_prefix(1);
    return number;
}

bool isPictureName(const fs::path& path) {
    const std::string ending = lower(path.extension().string());
    return ending == ".png" || ending == ".tif" || ending == ".tiff";
}

/// A name by its last number.
struct Numbered {
    std::uint64_t number = 0;
    std::string around;  ///< the rest of it
};

std::optional<Numbered> numbered(const std::string& name) {
    const auto end = name.find_last_of("0123456789") + 1;  // npos + 1 is 0
    auto begin = end;
    while (begin > 0 && isDigit(name[begin - 1])) --begin;
    constexpr std::size_t mostDigits = 18;
    if (begin == end || end - begin > mostDigits) return std::nullopt;
    return Numbered{std::stoull(name.substr(begin, end - begin)),
                    name.substr(0, begin) + '#' + name.substr(end)};
}

/// Names that differ by a number alone, which rises by even steps but for a place where it leaves some out:
/// a slice is missing, and what follows it would lie in the wrong place.
Status checkNoneMissing(const std::vector<fs::path>& files) {
    std::vector<std::uint64_t> numbers;
    std::string around;
    for (const auto& file : files) {
        const auto name = numbered(file.filename().string());
        if (!name || (!numbers.empty() && name->around != around)) return success();
        numbers.push_back(name->number);
        around = name->around;
    }
    std::adjacent_difference(numbers.begin(), numbers.end(), numbers.begin());
    if (numbers.size() < 2) return success();
    const auto step = *std::min_element(numbers.begin() + 1, numbers.end());
    for (std::size_t i = 1; i < numbers.size() && step > 0; ++i) {
        if (numbers[i] == step) continue;
        return corrupt(files[i].filename().string(),
                       fmt::format("follows {}, where the others' numbers rise by {}: a slice is missing",
                                   files[i - 1].filename().string(), step));
    }
    return success();
}

}  // namespace

bool naturallyLess(std::string_view a, std::string_view b) {
    const std::string_view wholeA = a, wholeB = b;
    while (!a.empty() && !b.empty()) {
        if (isDigit(a.front()) && isDigit(b.front())) {
            const auto numberA = takeNumber(a), numberB = takeNumber(b);
            if (numberA.size() != numberB.size()) return numberA.size() < numberB.size();
            if (numberA != numberB) return numberA < numberB;
        } else {
            if (a.front() != b.front()) return a.front() < b.front();
            a.remove_prefix(1);
            b.remove_prefix(1);
        }
    }
    if (a.empty() != b.empty()) return a.empty();
    return wholeA < wholeB;
}

bool namesPictures(const fs::path& input) {
    std::error_code code;
    if (fs::exists(input, code)) return fs::is_directory(input, code);
    return input.filename().string().find_first_of("*?") != std::string::npos;
}

Result<std::vector<fs::path>> pictureFiles(const fs::path& input) {
    std::error_code code;
    const bool whole = fs::is_directory(input, code);
    const std::string pattern = input.filename().string();
    const fs::path folder = whole ? input : input.parent_path().empty() ? fs::path(".") : input.parent_path();
    std::vector<fs::path> files;
    for (fs::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code)) {
        const fs::path name = entry->path().filename();
        if (whole ? isPictureName(name) && name.string().front() != '.'
                  : fnmatch(pattern.c_str(), name.c_str(), FNM_PERIOD) == 0) {
            files.push_back(entry->path());
        }
        if (files.size() <= VolumeShape::maxDimension) continue;
        return Error{ErrorCode::resourceExhausted, pattern,
                     fmt::format("are more than {} pictures", VolumeShape::maxDimension)};
    }
    if (code && code != std::errc::no_such_file_or_directory) {
        const bool denied = code == std::errc::permission_denied;
        return Error{denied ? ErrorCode::permissionDenied : ErrorCode::internal, folder.filename().string(),
                     "cannot be read: " + code.message()};
    }
    if (files.empty()) {
        return notFound(pattern, whole ? "is a folder without DICOM files, PNG or TIFF pictures"
                                       : "no file has a name like this");
    }
    std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
        return naturallyLess(a.filename().string(), b.filename().string());
    });
    MOTE_RETURN_IF_ERROR(checkNoneMissing(files));
    return files;
}

}  // namespace mote::prep
