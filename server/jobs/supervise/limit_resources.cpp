// SPDX-License-Identifier: GPL-3.0-or-later
#include <fcntl.h>
#include <linux/capability.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/statvfs.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string>

#include "protocol/base/system_error.h"
#include "server/jobs/supervise/supervise.h"
#include "storage/files/file_descriptor.h"

namespace mote::server {
namespace {

using storage::FileDescriptor;

constexpr int kLeastPriority = 19;
constexpr std::uint64_t kDescriptors = 4096;
constexpr std::uint64_t kHeadroom = std::uint64_t{1} << 29;  // libraries, stacks of threads
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kLimitsMemory = false;  // their shadow is as large as the address space, and counts
#else
constexpr bool kLimitsMemory = true;
#endif

Status lower(int resource, std::uint64_t value) {
    rlimit limit{};
    getrlimit(static_cast<__rlimit_resource_t>(resource), &limit);
    limit.rlim_cur = limit.rlim_max = std::min<rlim_t>(value, limit.rlim_max);
    if (setrlimit(static_cast<__rlimit_resource_t>(resource), &limit) == 0) return success();
    return failedCall("setrlimit");
}

std::uint64_t memoryFor(std::uint64_t limit) {
    if (limit > 0) return limit;
    const auto pages = static_cast<std::uint64_t>(std::max(sysconf(_SC_PHYS_PAGES), 0L));
    return pages * static_cast<std::uint64_t>(std::max(sysconf(_SC_PAGESIZE), 0L)) / 4 * 3;
}

/// No file is larger than what is free where it is made. Of a place that cannot be asked nothing is known.
Status limitFileSize(const std::vector<std::filesystem::path>& writable) {
    struct statvfs place {};
    if (writable.empty() || statvfs(writable.front().c_str(), &place) != 0) return success();
    const std::uint64_t room = std::uint64_t{place.f_bavail} * place.f_frsize;
    return room == 0 ? success() : lower(RLIMIT_FSIZE, room);
}

/// Kernels that share time between sessions first, and within each by niceness, ask for that of the session
/// as well. Best effort: many kernels do not.
void lowerSession(int niceness) {
    const FileDescriptor file(open("/proc/self/autogroup", O_WRONLY | O_CLOEXEC));
    const auto text = std::to_string(niceness);
    if (!file.valid() || write(file.get(), text.data(), text.size()) < 0) return;
}

/// Of a superuser's server: his jobs read what he may read, and that is all that is left of his powers.
Status dropCapabilities() {
    __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
    __user_cap_data_struct sets[_LINUX_CAPABILITY_U32S_3] = {};
    if (syscall(SYS_capget, &header, sets) != 0) return failedCall("capget");
    constexpr auto reading = std::uint32_t{1} << CAP_DAC_READ_SEARCH;
    const auto kept = sets[0].permitted & reading;
    sets[0] = {kept, kept, 0};
    sets[1] = {};
    if (syscall(SYS_capset, &header, sets) == 0) return success();
    return failedCall("capset");
}

}  // namespace

Status limitResources(const Rights& rights) {
    MOTE_RETURN_IF_ERROR(lower(RLIMIT_CORE, 0));
    MOTE_RETURN_IF_ERROR(lower(RLIMIT_NOFILE, kDescriptors));
    MOTE_RETURN_IF_ERROR(limitFileSize(rights.writable));
    if (rights.fileSize > 0) MOTE_RETURN_IF_ERROR(lower(RLIMIT_FSIZE, rights.fileSize));
    // RLIMIT_DATA and not RLIMIT_AS: mapped files are no memory that anyone else misses. What is shared and
    // no file's it does not count; such memory limitCalls() denies.
    if (kLimitsMemory) MOTE_RETURN_IF_ERROR(lower(RLIMIT_DATA, memoryFor(rights.memory) + kHeadroom));
    const int niceness =
        std::min(kLeastPriority, getpriority(PRIO_PROCESS, 0) + std::max(rights.niceness, 0));
    setpriority(PRIO_PROCESS, 0, niceness);
    lowerSession(niceness);
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return failedCall("no_new_privs");
    return dropCapabilities();
}

}  // namespace mote::server
