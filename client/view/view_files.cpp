// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/view_files.h"

#include <fmt/format.h>

namespace mote::client {

std::filesystem::path freshPath(const std::filesystem::path& usual) {
    constexpr int most = 10000;  // then one is offered that the user is asked about
    std::error_code code;
    auto path = usual;
    for (int number = 2; number <= most; ++number) {
        if (std::filesystem::symlink_status(path, code).type() == std::filesystem::file_type::not_found)
            break;
        path = usual;
        path.replace_filename(
            fmt::format("{}-{}{}", usual.stem().string(), number, usual.extension().string()));
    }
    return path;
}

}  // namespace mote::client
