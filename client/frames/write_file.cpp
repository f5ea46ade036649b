// SPDX-License-Identifier: GPL-3.0-or-later
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "client/frames/picture_file.h"

namespace mote::client {
namespace {

Error fromErrno(const std::filesystem::path& path, std::string_view what, int number) {
    const auto code = number == EACCES || number == EPERM || number == EROFS    ? ErrorCode::permissionDenied
                      : number == ENOENT || number == ENOTDIR                   ? ErrorCode::notFound
                      : number == ENOSPC || number == EDQUOT || number == EFBIG ? ErrorCode::resourceExhausted
                                                                                : ErrorCode::internal;
    return {code, path.string(), fmt::format("{}: {}", what, std::strerror(number))};
}

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
    if (file < 0) return fromErrno(path, "cannot be written", errno);
    int failure = writeAll(file, bytes);
    if (::close(file) != 0 && failure == 0) failure = errno;
    if (failure == 0 && ::rename(part.c_str(), path.c_str()) != 0) failure = errno;
    if (failure == 0) return success();
    ::unlink(part.c_str());
    return fromErrno(path, "cannot be written", failure);
}

}  // namespace mote::client
