// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/mapped_file.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <cerrno>

#include "storage/read_file.h"
#include "storage/system_error.h"

namespace mote::storage {

Result<MappedFile> MappedFile::open(const std::filesystem::path& path, std::uint64_t expectedSize) {
    const auto file = openRegular(path);
    if (!file.ok()) return file.error();
    struct stat status {};
    if (::fstat(file->get(), &status) != 0) return systemError(errno, path.string(), "cannot be opened");
    const auto size = static_cast<std::uint64_t>(status.st_size);
    if (size != expectedSize) {
        return Error{ErrorCode::corrupt, path.string(),
                     fmt::format("has {} bytes where the manifest says {}: it is truncated or was changed",
                                 size, expectedSize)};
    }
    if (size == 0) return MappedFile({});
    void* address = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, file->get(), 0);
    if (address == MAP_FAILED) return systemError(errno, path.string(), "cannot be mapped");
    return MappedFile({static_cast<const std::byte*>(address), size});
}

MappedFile::~MappedFile() {
    if (!bytes_.empty()) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

}  // namespace mote::storage
