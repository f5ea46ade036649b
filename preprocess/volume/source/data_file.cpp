// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/source/data_file.h"

#include <algorithm>
#include <string>
#include <system_error>

namespace mote::prep {

namespace fs = std::filesystem;

Result<ByteStreamPtr> dataFileStream(const fs::path& header, std::string_view name) {
    const std::string where = header.filename().string();
    if (name.find('\0') != std::string_view::npos) {
        return Error{ErrorCode::corrupt, where, "names a data file that can have no such name"};
    }
    std::error_code code;
    const fs::path folder =
        fs::weakly_canonical(header.parent_path().empty() ? "." : header.parent_path(), code);
    if (code) return Error{ErrorCode::notFound, where, "cannot be found: " + code.message()};
    const fs::path file = fs::weakly_canonical(folder / fs::path(name), code);
    const auto [inFolder, inFile] = std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
    if (code || inFolder != folder.end()) {
        return Error{ErrorCode::permissionDenied, where,
                     "names a data file outside of its own folder: move it there, or link the folder"};
    }
    auto stream = fileStream(file);
    if (stream) return stream;
    Error error = stream.error();
    error.where = where + ": data file " + error.where;
    return error;
}

}  // namespace mote::prep
