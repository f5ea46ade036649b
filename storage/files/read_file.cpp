// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/files/read_file.h"
#include "protocol/scene/system_error.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>

namespace mote::storage {

Result<FileDescriptor> openRegular(const std::filesystem::path& path) {
    // O_NONBLOCK: a named pipe in a file's place must not make the server wait.
    FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
    if (!file.valid() && errno == ELOOP) {
        return Error{ErrorCode::corrupt, path.string(), "is a link, where a dataset has files of its own"};
    }
    if (!file.valid()) return systemError(errno, path.string(), "cannot be opened");
    struct stat status {};
    if (::fstat(file.get(), &status) != 0) return systemError(errno, path.string(), "cannot be opened");
    if (!S_ISREG(status.st_mode)) return Error{ErrorCode::corrupt, path.string(), "is not a regular file"};
    return file;
}

Result<std::string> readWhole(const std::filesystem::path& path, std::size_t limit) {
    MOTE_ASSIGN_OR_RETURN(const auto file, openRegular(path));
    std::string text;
    while (true) {
        constexpr std::size_t piece = std::size_t{1} << 18;
        const std::size_t begin = text.size();
        text.resize(begin + piece);
        const ssize_t got = ::read(file.get(), text.data() + begin, piece);
        text.resize(begin + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return systemError(errno, path.string(), "cannot be read");
        if (got == 0) return text;
        if (text.size() > limit) {
            return Error{ErrorCode::resourceExhausted, path.string(),
                         fmt::format("is larger than the {} bytes that a file of its kind may have", limit)};
        }
    }
}

}  // namespace mote::storage
