// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/draft_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "protocol/base/system_error.h"
#include "storage/files/dataset_file.h"
#include "storage/files/file_descriptor.h"

namespace mote::prep {

namespace fs = std::filesystem;

Result<DraftFile> DraftFile::create(const fs::path& output) {
    std::error_code ignored;
    if (!output.has_filename()) {
        return invalid(output.string(), "is no name for a file");
    }
    if (fs::exists(fs::symlink_status(output, ignored))) {
        return Error{ErrorCode::alreadyExists, output.string(), "exists already and is never replaced"};
    }
    // A process that was killed may have left a file under our number: take the next name, touch nothing.
    for (int attempt = 0; attempt < 100; ++attempt) {
        fs::path path = output;
        path += fmt::format(".partial-{}", ::getpid());
        if (attempt > 0) path += fmt::format("-{}", attempt);
        const storage::FileDescriptor file(
            ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
        if (file.valid()) return DraftFile(output, path);
        if (errno != EEXIST) return systemError(errno, output.string(), "cannot be made");
    }
    return Error{ErrorCode::alreadyExists, output.string(), "too many unfinished copies lie beside it"};
}

DraftFile::DraftFile(DraftFile&& other) noexcept
    : output_(std::move(other.output_)), path_(std::exchange(other.path_, {})) {}

DraftFile::~DraftFile() {
    if (!path_.empty()) ::unlink(path_.c_str());
}

Status DraftFile::reserve(std::uint64_t bytes) const {
    const auto what =
        fmt::format("needs {:.1f} MB, but they cannot be had", static_cast<double>(bytes) / 1e6);
    const storage::FileDescriptor file(::open(path_.c_str(), O_WRONLY | O_CLOEXEC));
    if (!file.valid()) return systemError(errno, output_.string(), "cannot be opened");
    rlimit limit{};
    if (::getrlimit(RLIMIT_FSIZE, &limit) == 0 && bytes > limit.rlim_cur) {
        return systemError(EFBIG, output_.string(), what);
    }
    int result = 0;
    do {
        result = ::fallocate(file.get(), FALLOC_FL_KEEP_SIZE, 0, static_cast<off_t>(bytes));
    } while (result != 0 && errno == EINTR);
    if (result == 0) return success();
    if (errno != EOPNOTSUPP && errno != ENOSYS) return systemError(errno, output_.string(), what);
    std::error_code code;
    const auto space = fs::space(path_, code);
    if (!code && space.available < bytes) return systemError(ENOSPC, output_.string(), what);
    return success();
}

Status DraftFile::publish() {
    MOTE_RETURN_IF_ERROR(storage::syncPath(path_));
    MOTE_RETURN_IF_ERROR(storage::publishByRename(path_, output_));
    path_.clear();
    return success();
}

}  // namespace mote::prep
