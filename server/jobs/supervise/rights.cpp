// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/supervise/rights.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <string>
#include <vector>

#include "protocol/scene/system_error.h"
#include "storage/files/file_descriptor.h"

namespace mote::server {
namespace {

#if defined(__x86_64__)
constexpr unsigned kArchitecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr unsigned kArchitecture = AUDIT_ARCH_AARCH64;
#else
constexpr unsigned kArchitecture = 0;
#endif

// Nothing that makes a dataset or a film needs these; each of them is a way out of it.
constexpr int kDenied[] = {
    SYS_socket,
    SYS_socketpair,
    SYS_ptrace,
    SYS_process_vm_readv,
    SYS_process_vm_writev,
    SYS_pidfd_getfd,
    SYS_keyctl,
    SYS_add_key,
    SYS_request_key,
    SYS_bpf,
    SYS_perf_event_open,
    SYS_userfaultfd,
    SYS_mount,
    SYS_umount2,
    SYS_pivot_root,
    SYS_chroot,
    SYS_unshare,
    SYS_setns,
    SYS_move_mount,
    SYS_open_tree,
    SYS_fsopen,
    SYS_open_by_handle_at,
    SYS_init_module,
    SYS_finit_module,
    SYS_delete_module,
    SYS_kexec_load,
    SYS_reboot,
    SYS_swapon,
    SYS_io_uring_setup,
    SYS_io_uring_enter,
    SYS_io_uring_register,
};

Error failure(const char* what) {
    return {ErrorCode::internal, what, systemMessage(errno)};
}

sock_filter statement(int code, unsigned value) {
    return {static_cast<__u16>(code), 0, 0, value};
}

sock_filter jump(int code, unsigned value, int whenTrue, int whenFalse) {
    return {static_cast<__u16>(code), static_cast<__u8>(whenTrue), static_cast<__u8>(whenFalse), value};
}

constexpr unsigned refuse = SECCOMP_RET_ERRNO | EPERM;

/// Answers a call of socket(), of any other nothing.
void addUnixSockets(std::vector<sock_filter>& filter) {
    // The family is an int, of which both processors have the low half first.
    const std::array rule{
        statement(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, args)),
        jump(BPF_JMP | BPF_JEQ | BPF_K, AF_UNIX, 0, 1),
        statement(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
        statement(BPF_RET | BPF_K, refuse),
    };
    filter.push_back(jump(BPF_JMP | BPF_JEQ | BPF_K, SYS_socket, 0, static_cast<int>(rule.size())));
    for (const auto& line : rule) filter.push_back(line);
}

std::vector<sock_filter> program(const Rights& rights) {
    std::vector<sock_filter> filter{
        statement(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, arch)),
        jump(BPF_JMP | BPF_JEQ | BPF_K, kArchitecture, 1, 0),
        statement(BPF_RET | BPF_K, refuse),  // calls of another architecture (32 bits) have other numbers
        statement(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
    };
#if defined(__x86_64__)
    constexpr unsigned x32 = 0x40000000;
    filter.push_back(jump(BPF_JMP | BPF_JGE | BPF_K, x32, 0, 1));
    filter.push_back(statement(BPF_RET | BPF_K, refuse));
#endif
    if (rights.unixSockets) addUnixSockets(filter);
    for (const int call : kDenied) {
        filter.push_back(jump(BPF_JMP | BPF_JEQ | BPF_K, static_cast<unsigned>(call), 0, 1));
        filter.push_back(statement(BPF_RET | BPF_K, refuse));
    }
    filter.push_back(statement(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
    return filter;
}

using storage::FileDescriptor;

// Landlock's ABI 3 has it; the headers of this system may not know it yet.
constexpr std::uint64_t kTruncate = std::uint64_t{1} << 14;

constexpr std::uint64_t kRead = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR;
constexpr std::uint64_t kExecute = kRead | LANDLOCK_ACCESS_FS_EXECUTE;
constexpr std::uint64_t kFile =  // what may be allowed of a file that is no folder
    LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_EXECUTE | kTruncate;

/// Every right over files that this kernel's Landlock knows; 0: it has none.
std::uint64_t knownRights() {
    const long abi = syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
    if (abi < 1) return 0;
    std::uint64_t rights = (std::uint64_t{1} << 13) - 1;
    if (abi >= 2) rights |= LANDLOCK_ACCESS_FS_REFER;
    if (abi >= 3) rights |= kTruncate;
    return rights;
}

Status allow(int rules, const std::filesystem::path& path, std::uint64_t rights) {
    const FileDescriptor folder(open(path.c_str(), O_PATH | O_CLOEXEC));
    struct stat kind {};
    if (!folder.valid() || fstat(folder.get(), &kind) != 0) return success();  // nothing there to allow
    landlock_path_beneath_attr rule{};
    rule.allowed_access = S_ISDIR(kind.st_mode) ? rights : rights & kFile;
    rule.parent_fd = folder.get();
    if (syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &rule, 0) == 0) return success();
    return failure(path.c_str());
}

constexpr int kLeastPriority = 19;
constexpr std::uint64_t kHeadroom = std::uint64_t{1} << 29;  // libraries, stacks of threads

Status lower(int resource, std::uint64_t value) {
    rlimit limit{};
    getrlimit(static_cast<__rlimit_resource_t>(resource), &limit);
    limit.rlim_cur = limit.rlim_max = std::min<rlim_t>(value, limit.rlim_max);
    if (setrlimit(static_cast<__rlimit_resource_t>(resource), &limit) == 0) return success();
    return failure("setrlimit");
}

/// Kernels that share time between sessions first, and within each by niceness, ask for that of the session
/// as well. Best effort: many kernels do not.
void lowerSession(int niceness) {
    const FileDescriptor file(open("/proc/self/autogroup", O_WRONLY | O_CLOEXEC));
    const auto text = std::to_string(niceness);
    if (!file.valid() || write(file.get(), text.data(), text.size()) < 0) return;
}

}  // namespace

Status limitCalls(const Rights& rights) {
    if (kArchitecture == 0)
        return Error{ErrorCode::unsupported, "seccomp", "is not set up for this processor"};
    auto filter = program(rights);
    const sock_fprog code{static_cast<unsigned short>(filter.size()), filter.data()};
    if (prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &code, 0, 0) == 0) return success();
    return Error{ErrorCode::unsupported, "seccomp", systemMessage(errno)};
}

Status limitFiles(const Rights& rights) {
    const auto known = knownRights();
    if (known == 0) return Error{ErrorCode::unsupported, "", "this kernel has no Landlock"};
    landlock_ruleset_attr attributes{};
    attributes.handled_access_fs = known;
    const FileDescriptor rules(static_cast<int>(
        syscall(SYS_landlock_create_ruleset, &attributes, sizeof attributes.handled_access_fs, 0)));
    if (!rules.valid()) return failure("landlock_create_ruleset");
    for (const auto& path : rights.readable) MOTE_RETURN_IF_ERROR(allow(rules.get(), path, kRead));
    for (const auto& path : rights.executable) MOTE_RETURN_IF_ERROR(allow(rules.get(), path, kExecute));
    const auto all = known & ~std::uint64_t{LANDLOCK_ACCESS_FS_EXECUTE | LANDLOCK_ACCESS_FS_MAKE_CHAR |
                                            LANDLOCK_ACCESS_FS_MAKE_BLOCK | LANDLOCK_ACCESS_FS_MAKE_SOCK};
    for (const auto& path : rights.writable) MOTE_RETURN_IF_ERROR(allow(rules.get(), path, all));
    if (syscall(SYS_landlock_restrict_self, rules.get(), 0) == 0) return success();
    return failure("landlock_restrict_self");
}

Status limitResources(const Rights& rights) {
    MOTE_RETURN_IF_ERROR(lower(RLIMIT_CORE, 0));
    // RLIMIT_DATA and not RLIMIT_AS: mapped files are no memory that anyone else misses.
    if (rights.memory != 0) MOTE_RETURN_IF_ERROR(lower(RLIMIT_DATA, rights.memory + kHeadroom));
    const int niceness =
        std::min(kLeastPriority, getpriority(PRIO_PROCESS, 0) + std::max(rights.niceness, 0));
    setpriority(PRIO_PROCESS, 0, niceness);
    lowerSession(niceness);
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0) return success();
    return failure("no_new_privs");
}

}  // namespace mote::server
