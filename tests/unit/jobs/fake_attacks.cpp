// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/jobs/fake_attacks.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <functional>
#include <map>

namespace {

using Attack = std::function<bool(const std::string& word, const std::string& root)>;

pid_t number(const std::string& word) {
    return static_cast<pid_t>(std::stol(word));
}

/// A child that lives for as long as a test may take.
bool child(bool ownSession) {
    const pid_t made = fork();
    if (made != 0) return made > 0;
    if (ownSession) setsid();
    sleep(600);
    _exit(0);
}

bool take(const std::string& word, int flags) {
    const std::size_t bytes = std::stoul(word) << 20;
    void* memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, flags | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) return false;
    for (std::size_t i = 0; i < bytes; i += 4096) static_cast<volatile char*>(memory)[i] = 1;
    return munmap(memory, bytes) == 0;
}

bool readMemory(pid_t other) {
    char byte = 0;
    iovec mine{&byte, 1}, theirs{&byte, 1};
    // Of an address that is not mapped there the error is EFAULT: the call itself was let through.
    return process_vm_readv(other, &mine, 1, &theirs, 1, 0) == 1 || errno == EFAULT;
}

bool bindAbstract() {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::snprintf(address.sun_path + 1, sizeof address.sun_path - 1, "mote-test-%d", getpid());
    return bind(socket(AF_UNIX, SOCK_STREAM, 0), reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
}

bool old(const std::string& path) {
    const timespec times[2] = {{1, 0}, {1, 0}};
    return utimensat(AT_FDCWD, path.c_str(), times, 0) == 0;
}

bool lowerLimit(pid_t other) {
    const rlimit none{8, 8};
    return syscall(SYS_prlimit64, other, RLIMIT_NOFILE, &none, nullptr) == 0;
}

bool printEnvironment() {
    for (char** entry = environ; *entry; ++entry) {
        const std::string text(*entry);
        fmt::print(stderr, "variable {}\n", text.substr(0, text.find('=')));
    }
    return true;
}

const std::map<std::string, Attack>& attacks() {
    static const std::map<std::string, Attack> all{
        {"kill", [](auto& w, auto&) { return kill(number(w), SIGKILL) == 0; }},
        {"fork", [](auto&, auto&) { return child(false); }},
        {"take", [](auto& w, auto&) { return take(w, MAP_PRIVATE); }},
        {"share", [](auto& w, auto&) { return take(w, MAP_SHARED); }},
        {"setsid", [](auto&, auto&) { return child(true); }},
        {"namespace",
         [](auto&, auto&) { return syscall(SYS_clone, CLONE_NEWUSER | SIGCHLD, nullptr, 0, 0, 0) >= 0; }},
        {"unshare", [](auto&, auto&) { return unshare(CLONE_NEWUSER) == 0; }},
        {"ptrace", [](auto& w, auto&) { return ptrace(PTRACE_ATTACH, number(w), nullptr, nullptr) == 0; }},
        {"memory", [](auto& w, auto&) { return readMemory(number(w)); }},
        {"chmod", [](auto& w, auto&) { return chmod(w.c_str(), 0) == 0; }},
        {"fchmod", [](auto& w, auto&) { return fchmod(open(w.c_str(), O_RDONLY), 0) == 0; }},
        {"times", [](auto& w, auto&) { return old(w); }},
        {"cut", [](auto& w, auto&) { return open(w.c_str(), O_RDONLY | O_TRUNC) >= 0; }},
        {"remove", [](auto& w, auto&) { return unlink(w.c_str()) == 0; }},
        {"link", [](auto& w, auto& root) { return link(w.c_str(), (root + "/second").c_str()) == 0; }},
        {"renice", [](auto& w, auto&) { return setpriority(PRIO_PROCESS, number(w), 19) == 0; }},
        {"limit", [](auto& w, auto&) { return lowerLimit(number(w)); }},
        {"bind", [](auto&, auto&) { return bindAbstract(); }},
        {"memfd", [](auto&, auto&) { return memfd_create("x", 0) >= 0; }},
        {"prctl", [](auto&, auto&) { return prctl(PR_SET_PDEATHSIG, 0) == 0; }},
        {"terminal", [](auto&, auto&) { return ioctl(0, TIOCSTI, "x") == 0 || errno == ENOTTY; }},
        {"environment", [](auto&, auto&) { return printEnvironment(); }},
    };
    return all;
}

}  // namespace

bool attack(const std::string& verb, const std::string& word, const std::string& root) {
    const auto found = attacks().find(verb);
    if (found == attacks().end()) return false;
    const bool worked = found->second(word, root);
    fmt::print(stderr, "{}: {}\n", verb, worked ? "allowed" : std::strerror(errno));
    return true;
}
