// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/partial_output.h"

#include <string>
#include <vector>

namespace mote::server {

std::size_t removePartialOutput(const std::filesystem::path& output) {
    const auto draft = "." + output.filename().string() + ".partial";
    std::vector<std::filesystem::path> drafts;
    std::error_code code;
    for (const auto& entry : std::filesystem::directory_iterator(output.parent_path(), code)) {
        if (entry.path().filename().string().starts_with(draft)) drafts.push_back(entry.path());
    }
    for (const auto& path : drafts) std::filesystem::remove_all(path, code);
    return drafts.size();
}

}  // namespace mote::server
