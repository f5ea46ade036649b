// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/input_files.h"

#include <algorithm>
#include <string>
#include <system_error>
#include <utility>

#include "preprocess/readers/adios2/bp_tree.h"
#include "preprocess/readers/known_files.h"
#include "preprocess/readers/openpmd/layout.h"
#include "preprocess/readers/series_source.h"

namespace mote::prep {
namespace {

constexpr std::size_t maxFiles = 100'000;

using Paths = std::vector<std::filesystem::path>;

Result<Paths> matching(const std::filesystem::path& input) {
    std::error_code code;
    const std::string pattern = input.filename().string();
    std::vector<std::pair<std::int64_t, std::filesystem::path>> found;
    const std::filesystem::path folder = input.parent_path().empty() ? "." : input.parent_path();
    for (std::filesystem::directory_iterator entry(folder, code), end; !code && entry != end;
         entry.increment(code)) {
        if (const auto number = matchIteration(pattern, entry->path().filename().string())) {
            found.emplace_back(*number, entry->path());
        }
        if (found.size() > maxFiles) break;
    }
    if (found.empty()) return notFound(pattern, "no file has a name like this");
    std::sort(found.begin(), found.end());
    Paths files;
    for (auto& [number, path] : found) files.push_back(std::move(path));
    return files;
}

Result<Paths> inFolder(const std::filesystem::path& folder) {
    std::error_code code;
    Paths files;
    for (std::filesystem::directory_iterator entry(folder, code), end; !code && entry != end;
         entry.increment(code)) {
        std::error_code kind;
        const bool hidden = entry->path().filename().string().starts_with('.');
        if (!hidden && (entry->is_regular_file(kind) || BpTree::isBp(entry->path())))
            files.push_back(entry->path());
        if (files.size() > maxFiles) break;
    }
    if (files.empty()) {
        return notFound(folder.filename().string(),
                        "is a folder without files; name the files or the folder that holds them");
    }
    std::sort(files.begin(), files.end());
    return inOrder(std::move(files));
}

}  // namespace

Result<std::vector<InputFile>> inputFiles(const std::vector<std::filesystem::path>& inputs) {
    std::vector<InputFile> files;
    for (const std::filesystem::path& input : inputs) {
        std::error_code code;
        const bool folder = std::filesystem::is_directory(input, code) && !BpTree::isBp(input) &&
                            !knownFolder(input, WantedAs::particles);
        const bool pattern =
            !std::filesystem::exists(input, code) && input.filename().string().find('%') != std::string::npos;
        if (!folder && !pattern) {
            files.push_back({input, true});
            continue;
        }
        MOTE_ASSIGN_OR_RETURN(auto some, folder ? inFolder(input) : matching(input));
        for (auto& path : some) files.push_back({std::move(path), false});
        if (files.size() > maxFiles) {
            return Error{ErrorCode::resourceExhausted, "inputs", "are more than 100000 files"};
        }
    }
    if (files.empty()) return invalid("inputs", "no input was given");
    return files;
}

}  // namespace mote::prep
