// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/files/scratch_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>

#include "protocol/scene/system_error.h"
#include "storage/files/write_file.h"

namespace mote::storage {

Result<std::unique_ptr<ScratchFile>> ScratchFile::create(const std::filesystem::path& path) {
    FileDescriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (!file.valid()) return systemError(errno, path.string(), "cannot be made");
    return std::unique_ptr<ScratchFile>(new ScratchFile(path, std::move(file), true));
}

Result<std::unique_ptr<ScratchFile>> ScratchFile::open(const std::filesystem::path& path) {
    FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (!file.valid()) return systemError(errno, path.string(), "cannot be opened");
    return std::unique_ptr<ScratchFile>(new ScratchFile(path, std::move(file), false));
}

ScratchFile::~ScratchFile() {
    if (own_) ::unlink(path_.c_str());
}

Result<std::uint64_t> ScratchFile::append(std::span<const std::byte> bytes) {
    const auto at = end_.fetch_add(bytes.size());
    MOTE_RETURN_IF_ERROR(writeAt(file_.get(), at, bytes, path_));
    return at;
}

Status ScratchFile::read(std::uint64_t at, std::span<std::byte> bytes) const {
    return readAt(file_.get(), at, bytes, path_);
}

Status ScratchFile::sync() const {
    return syncPath(path_);
}

}  // namespace mote::storage
