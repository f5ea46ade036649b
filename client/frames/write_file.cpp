// SPDX-License-Identifier: GPL-3.0-or-later
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>

#include "client/frames/picture_file.h"
#include "protocol/scene/system_error.h"

namespace mote::client {
namespace {

/// 0, or errno.
int writeAll(int file, const std::vector<std::uint8_t>& bytes) {
    std::size_t done = 0;
    while (done < bytes.size()) {
        const auto count = ::write(file, bytes.data() + done, bytes.size() - done);
        if (count < 0 && errno != EINTR) return errno;
        if (count > 0) done += static_cast<std::size_t>(count);
    }
    return 0;
}

}  // namespace

Status writeFile(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes) {
    const auto hidden = fmt::format(".{}.{}", path.filename().string(), ::getpid());
    const auto part = path.parent_path() / hidden;
    ::unlink(part.c_str());  // of an earlier process with our number that was killed
    const int file = ::open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file < 0) return systemError(errno, path.string(), "cannot be written");
    int failure = writeAll(file, bytes);
    if (::close(file) != 0 && failure == 0) failure = errno;
    if (failure == 0 && ::rename(part.c_str(), path.c_str()) != 0) failure = errno;
    if (failure == 0) return success();
    ::unlink(part.c_str());
    return systemError(failure, path.string(), "cannot be written");
}

}  // namespace mote::client
