// SPDX-License-Identifier: GPL-3.0-or-later
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>

#include <cerrno>
#include <cstddef>
#include <vector>

#include "protocol/scene/system_error.h"
#include "server/jobs/supervise/rights.h"

namespace mote::server {
namespace {

#if defined(__x86_64__)
constexpr unsigned kArchitecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr unsigned kArchitecture = AUDIT_ARCH_AARCH64;
#else
constexpr unsigned kArchitecture = 0;
#endif

// Nothing that reads a file and writes a dataset needs these; each of them is a way out of it.
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

sock_filter statement(int code, unsigned value) {
    return {static_cast<__u16>(code), 0, 0, value};
}

sock_filter jump(int code, unsigned value, int whenTrue, int whenFalse) {
    return {static_cast<__u16>(code), static_cast<__u8>(whenTrue), static_cast<__u8>(whenFalse), value};
}

std::vector<sock_filter> program() {
    constexpr unsigned refuse = SECCOMP_RET_ERRNO | EPERM;
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
    for (const int call : kDenied) {
        filter.push_back(jump(BPF_JMP | BPF_JEQ | BPF_K, static_cast<unsigned>(call), 0, 1));
        filter.push_back(statement(BPF_RET | BPF_K, refuse));
    }
    filter.push_back(statement(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
    return filter;
}

}  // namespace

Status limitCalls() {
    if (kArchitecture == 0)
        return Error{ErrorCode::unsupported, "seccomp", "is not set up for this processor"};
    auto filter = program();
    const sock_fprog code{static_cast<unsigned short>(filter.size()), filter.data()};
    if (prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &code, 0, 0) == 0) return success();
    return Error{ErrorCode::unsupported, "seccomp", systemMessage(errno)};
}

}  // namespace mote::server
