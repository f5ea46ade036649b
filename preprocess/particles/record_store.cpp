// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/record_store.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "protocol/scene/system_error.h"
#include "storage/files/dataset_file.h"

namespace mote::prep {
namespace {

/// A file without a name; if the file system has none, one whose name is taken away at once.
storage::FileDescriptor namelessFile(const std::filesystem::path& folder) {
    storage::FileDescriptor file(::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600));
    if (file.valid() || (errno != EOPNOTSUPP && errno != EISDIR && errno != ENOENT)) return file;
    std::string name = (folder / "spill-XXXXXX").string();
    file = storage::FileDescriptor(::mkostemp(name.data(), O_CLOEXEC));
    if (file.valid()) ::unlink(name.c_str());
    return file;
}

}  // namespace

Result<RecordStore> RecordStore::inMemory(std::uint64_t bytes) {
    RecordStore store;
    if (bytes == 0) return store;
    // Pages come as they are written to, not before.
    void* address =
        ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (address == MAP_FAILED) {
        return Error{ErrorCode::resourceExhausted, "",
                     fmt::format("there are no {} bytes of memory for the particles", bytes)};
    }
    // Large pages come sooner and are found sooner; without them it is slower, not wrong.
    static_cast<void>(::madvise(address, bytes, MADV_HUGEPAGE));
    store.memory_ = {static_cast<std::byte*>(address), bytes};
    return store;
}

Result<RecordStore> RecordStore::inFile(const std::filesystem::path& folder, std::uint64_t bytes) {
    RecordStore store;
    store.folder_ = folder;
    if (bytes == 0) return store;
    store.file_ = namelessFile(folder);
    if (!store.file_.valid()) {
        return systemError(errno, folder.string(), "cannot hold a temporary file");
    }
    int number = 0;
    do {
        number = ::fallocate(store.file_.get(), 0, 0, static_cast<off_t>(bytes)) == 0 ? 0 : errno;
    } while (number == EINTR);
    if (number == 0 || number == EOPNOTSUPP || number == ENOSYS) return store;
    return systemError(
        number, folder.string(),
        fmt::format("cannot hold a temporary file of the {} bytes that the memory limit makes needed",
                    bytes));
}

RecordStore::RecordStore(RecordStore&& other) noexcept
    : memory_(std::exchange(other.memory_, {})),
      file_(std::move(other.file_)),
      folder_(std::move(other.folder_)) {}

RecordStore& RecordStore::operator=(RecordStore&& other) noexcept {
    std::swap(memory_, other.memory_);
    std::swap(file_, other.file_);
    std::swap(folder_, other.folder_);
    return *this;
}

RecordStore::~RecordStore() {
    if (!memory_.empty()) ::munmap(memory_.data(), memory_.size());
}

Status RecordStore::writeBytes(std::uint64_t at, std::span<const std::byte> bytes) {
    if (bytes.empty()) return success();
    if (memory_.empty()) return storage::writeAt(file_.get(), at, bytes, folder_);
    MOTE_CHECK(at <= memory_.size() && bytes.size() <= memory_.size() - at);
    std::memcpy(memory_.data() + at, bytes.data(), bytes.size());
    return success();
}

Status RecordStore::readBytes(std::uint64_t at, std::span<std::byte> bytes) const {
    return storage::readAt(file_.get(), at, bytes, folder_);
}

}  // namespace mote::prep
