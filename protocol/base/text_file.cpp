// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/base/text_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <fstream>

#include "protocol/base/system_error.h"

namespace mote {
namespace {

constexpr std::size_t leastPiece = std::size_t{64} << 10;  // the memory of a file follows its size

}  // namespace

Result<std::string> readTextFile(const std::filesystem::path& path, std::size_t limit) {
    std::error_code code;
    if (std::filesystem::is_directory(path, code)) {
        return Error{ErrorCode::invalidArgument, path.string(), "is a directory, not a JSON file"};
    }
    errno = 0;
    std::ifstream file(path, std::ios::binary);
    if (!file) return systemError(errno, path.string(), "cannot be opened");
    std::string text;
    while (file && text.size() <= limit) {
        const std::size_t read = text.size();
        text.resize(std::min(limit + 1, std::max(leastPiece, 2 * read)));
        file.read(text.data() + read, static_cast<std::streamsize>(text.size() - read));
        text.resize(read + static_cast<std::size_t>(file.gcount()));
    }
    if (text.size() <= limit) return text;
    return Error{ErrorCode::resourceExhausted, path.string(),
                 fmt::format("is larger than the {} bytes that a file of its kind may have", limit)};
}

}  // namespace mote
