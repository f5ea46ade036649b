// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/orbit/page_cache.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <vector>

namespace mote::bench {
namespace {

/// An open file; closed with the object.
struct File {
    explicit File(const std::filesystem::path& path)
        : descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
        if (descriptor < 0) throw std::system_error(errno, std::generic_category(), path.string());
    }
    ~File() { ::close(descriptor); }
    File(const File&) = delete;
    File& operator=(const File&) = delete;

    int descriptor;
};

std::size_t cachedPages(const std::filesystem::path& path, std::size_t bytes) {
    const File file(path);
    void* const start = ::mmap(nullptr, bytes, PROT_READ, MAP_SHARED, file.descriptor, 0);
    if (start == MAP_FAILED) throw std::system_error(errno, std::generic_category(), path.string());
    const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    std::vector<unsigned char> held((bytes + page - 1) / page);
    const int failed = ::mincore(start, bytes, held.data());
    const int number = errno;
    ::munmap(start, bytes);
    if (failed != 0) throw std::system_error(number, std::generic_category(), path.string());
    std::size_t count = 0;
    for (const auto flag : held) count += flag & 1U;
    return count;
}

}  // namespace

void evict(const std::filesystem::path& folder) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        if (!entry.is_regular_file()) continue;
        const File file(entry.path());
        ::fsync(file.descriptor);  // what is not yet written stays
        if (const int number = ::posix_fadvise(file.descriptor, 0, 0, POSIX_FADV_DONTNEED); number != 0)
            throw std::system_error(number, std::generic_category(), entry.path().string());
    }
}

double cachedShare(const std::filesystem::path& folder) {
    const auto page = static_cast<double>(::sysconf(_SC_PAGESIZE));
    double cached = 0.0, all = 0.0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        if (!entry.is_regular_file() || entry.file_size() == 0) continue;
        cached += page * static_cast<double>(cachedPages(entry.path(), entry.file_size()));
        all += static_cast<double>(entry.file_size());
    }
    return all > 0.0 ? cached / all : 0.0;
}

}  // namespace mote::bench
