// SPDX-License-Identifier: GPL-3.0-or-later
//
// The kernel's clock of files is coarse: a test that changes a file twice waits until it can tell. A pure
// helper, any thread.
#pragma once

#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace mote::test {

/// When the file was changed last, in whatever way.
inline timespec changeTime(const std::filesystem::path& path) {
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) throw std::runtime_error("no " + path.string());
    return status.st_ctim;
}

/// Returns once a change of this file would get another time than its last one; a probe beside it tells.
inline void awaitNextTime(const std::filesystem::path& path) {
    const auto last = changeTime(path);
    const std::filesystem::path probe = path.string() + ".probe";
    for (auto now = last; now.tv_sec == last.tv_sec && now.tv_nsec == last.tv_nsec; now = changeTime(probe)) {
        std::ofstream(probe) << 'x';
    }
    std::filesystem::remove(probe);
}

}  // namespace mote::test
