// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/record_store.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "protocol/base/system_error.h"
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

StoreMemory::~StoreMemory() {
    for (const auto memory : kept_) ::munmap(memory.data(), memory.size());
}

std::span<std::byte> StoreMemory::take(std::uint64_t bytes) {
    constexpr std::uint64_t page = std::uint64_t{1} << 21;
    const std::uint64_t size = (bytes + page - 1) / page * page;
    const std::lock_guard lock(mutex_);
    auto memory = takeKept(size);
    if (memory.empty()) {
        release(size);
        // Pages come as they are written to, not before.
        void* address =
            ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
        if (address == MAP_FAILED) return {};
        memory = {static_cast<std::byte*>(address), size};
    }
    // Large pages come sooner and are found sooner; without them it is slower, not wrong.
    static_cast<void>(::madvise(memory.data(), memory.size(), MADV_HUGEPAGE));
    used_ += memory.size();
    most_ = std::max(most_, used_);
    release(0);
    return memory;
}

/// The smallest that is large enough; if none is, the largest, made longer.
std::span<std::byte> StoreMemory::takeKept(std::uint64_t bytes) {
    if (kept_.empty()) return {};
    const auto better = [&](const auto& a, const auto& b) {
        const bool enough = a.size() >= bytes;
        if (enough != (b.size() >= bytes)) return enough;
        return enough ? a.size() < b.size() : a.size() > b.size();
    };
    const auto best = std::min_element(kept_.begin(), kept_.end(), better);
    auto memory = *best;
    kept_.erase(best);
    keptBytes_ -= memory.size();
    if (memory.size() >= bytes) return memory;
    void* const longer = ::mremap(memory.data(), memory.size(), bytes, MREMAP_MAYMOVE);
    if (longer != MAP_FAILED) return {static_cast<std::byte*>(longer), bytes};
    ::munmap(memory.data(), memory.size());
    return {};
}

/// Keeps no more than may be beside what is used and `more`.
void StoreMemory::release(std::uint64_t more) {
    while (!kept_.empty() && used_ + more + keptBytes_ > std::max(most_, used_ + more)) {
        ::munmap(kept_.back().data(), kept_.back().size());
        keptBytes_ -= kept_.back().size();
        kept_.pop_back();
    }
}

void StoreMemory::giveBack(std::span<std::byte> memory) {
    const std::lock_guard lock(mutex_);
    used_ -= memory.size();
    keptBytes_ += memory.size();
    kept_.push_back(memory);
}

std::uint64_t StoreMemory::kept() const {
    const std::lock_guard lock(mutex_);
    return keptBytes_;
}

Result<RecordStore> RecordStore::inMemory(std::uint64_t bytes, std::shared_ptr<StoreMemory> memory) {
    RecordStore store;
    if (bytes == 0) return store;
    store.memory_ = memory->take(bytes);
    if (store.memory_.empty()) {
        return Error{ErrorCode::resourceExhausted, "",
                     fmt::format("there are no {} bytes of memory for the particles", bytes)};
    }
    store.owner_ = std::move(memory);
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
    : owner_(std::move(other.owner_)),
      memory_(std::exchange(other.memory_, {})),
      file_(std::move(other.file_)),
      folder_(std::move(other.folder_)) {}

RecordStore& RecordStore::operator=(RecordStore&& other) noexcept {
    std::swap(owner_, other.owner_);
    std::swap(memory_, other.memory_);
    std::swap(file_, other.file_);
    std::swap(folder_, other.folder_);
    return *this;
}

RecordStore::~RecordStore() {
    if (owner_) owner_->giveBack(memory_);
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
