// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/wire/private_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "protocol/base/system_error.h"

namespace mote::wire {
namespace {

/// Closes the descriptor of a file at the end of a scope.
class OpenFile {
  public:
    explicit OpenFile(int descriptor) : descriptor_(descriptor) {}
    ~OpenFile() {
        if (descriptor_ >= 0) ::close(descriptor_);
    }
    OpenFile(const OpenFile&) = delete;
    OpenFile& operator=(const OpenFile&) = delete;
    int descriptor() const { return descriptor_; }

  private:
    int descriptor_;
};

Status writeAll(const OpenFile& file, const std::filesystem::path& path, const std::string& text) {
    std::size_t done = 0;
    while (done < text.size()) {
        const ssize_t count = ::write(file.descriptor(), text.data() + done, text.size() - done);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return systemError(errno, path.string(), "cannot be written");
        done += static_cast<std::size_t>(count);
    }
    if (::fsync(file.descriptor()) != 0) return systemError(errno, path.string(), "cannot be written");
    return success();
}

/// mkostemp makes the file with mode 0600 under a name that nobody had before.
Status writeBeside(const std::filesystem::path& path, const std::string& text, std::string& temporary) {
    const OpenFile file(::mkostemp(temporary.data(), O_CLOEXEC));
    if (file.descriptor() < 0) return systemError(errno, path.string(), "cannot be made");
    MOTE_RETURN_IF_ERROR(writeAll(file, path, text));
    if (::rename(temporary.c_str(), path.c_str()) != 0)
        return systemError(errno, path.string(), "cannot be made");
    return success();
}

}  // namespace

Status writePrivateFile(const std::filesystem::path& path, const std::string& text) {
    std::string temporary = path.string() + ".XXXXXX";
    const auto status = writeBeside(path, text, temporary);
    if (!status.ok()) ::unlink(temporary.c_str());
    return status;
}

Result<std::string> readPrivateFile(const std::filesystem::path& path, std::size_t mostBytes) {
    const OpenFile file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
    if (file.descriptor() < 0) return systemError(errno, path.string(), "cannot be read");
    struct stat status {};
    if (::fstat(file.descriptor(), &status) != 0) return systemError(errno, path.string(), "cannot be read");
    if (!S_ISREG(status.st_mode)) return Error{ErrorCode::invalidArgument, path.string(), "is no plain file"};
    if (status.st_uid != ::geteuid())
        return Error{ErrorCode::permissionDenied, path.string(), "belongs to another user"};
    if ((status.st_mode & 077) != 0) {
        return Error{ErrorCode::permissionDenied, path.string(),
                     fmt::format("others may read this secret (mode {:04o}); chmod 600 it, and restart the "
                                 "server if they may have",
                                 status.st_mode & 07777)};
    }
    std::string text(mostBytes + 1, '\0');
    std::size_t done = 0;
    while (done < text.size()) {
        const ssize_t count = ::read(file.descriptor(), text.data() + done, text.size() - done);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return systemError(errno, path.string(), "cannot be read");
        if (count == 0) break;
        done += static_cast<std::size_t>(count);
    }
    if (done > mostBytes) {
        return Error{ErrorCode::invalidArgument, path.string(), "is too large"};
    }
    text.resize(done);
    return text;
}

}  // namespace mote::wire
