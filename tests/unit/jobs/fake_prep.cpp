// SPDX-License-Identifier: GPL-3.0-or-later
//
// A stand-in for mote-prep, and for mote-frames, that does what the request's title says, word by word, so
// that a test decides what a job does and when: no sleeps. It takes the arguments that the server gives them.
// Of a film and an export, ROOT is the job's own folder and fifos are made where they are waited at.
//   phase:NAME     reports progress with this phase        half:NAME   the same at 0.5
//   pids:          reports "PID SUPERVISOR" as its phase    print:TEXT  a line on stderr
//   wait:FIFO      reads a byte from ROOT/FIFO              exit:CODE   ends
//   publish:       makes the output (by one rename)         draft:      leaves a draft of it
//   ignore:        SIGTERM is ignored                       die:SIGNAL  kills itself
//   noise:         bytes that are no text on stderr         touch:PATH  makes a file; its error is printed
//   read:PATH      reads a file; its error is printed       socket:     opens a socket; its error is printed
//   limits:        prints the core limit and the niceness   file:NAME   appends a byte to a file in ROOT
//   input:         prints the first line of its first input
//   full:NAME      finds the disk full while ROOT/NAME is there
//   unix:          opens a Unix socket; its error is printed  wrong:KIND  makes an output that is a link, a
//                  pipe, set-uid, has a second name, or holds a link (attack() has other misdeeds)
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
#include <sysexits.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <map>
#include <sstream>

#include "protocol/base/json.h"
#include "protocol/mote.pb.h"

namespace {

// What a program that foreign bytes have taken over would try.

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

/// Tries `verb` on `word` and prints on stderr "VERB: allowed" or why not; false: it knows no such verb.
///   kill:PID     SIGKILL to another process       fork:        a child
///   take:MIB     private memory, written to       share:MIB    the same, shared and no file's
///   setsid:      a child in a session of its own  namespace:   CLONE_NEWUSER
///   unshare:     the same by unshare()            ptrace:PID   attaches
///   memory:PID   process_vm_readv                 chmod:PATH   takes all rights from a file
///   fchmod:PATH  the same of an open one          times:PATH   makes a file older
///   cut:PATH     opens to read with O_TRUNC       remove:PATH  unlinks
///   link:PATH    a second name in ROOT            renice:PID   lowers another's priority
///   limit:PID    lowers another's limits          bind:        an abstract Unix socket
///   memfd:       memory as a file                 prctl:       no more a signal when the parent ends
///   terminal:    writes into its terminal's input environment: prints its variables' names
bool attack(const std::string& verb, const std::string& word, const std::string& root) {
    const auto found = attacks().find(verb);
    if (found == attacks().end()) return false;
    const bool worked = found->second(word, root);
    fmt::print(stderr, "{}: {}\n", verb, worked ? "allowed" : std::strerror(errno));
    return true;
}

struct Fake {
    mote::proto::JobRequest request;
    std::map<std::string, std::filesystem::path> roots;
    std::filesystem::path connection;
    std::string draftId;
    int progress = -1;

    const std::filesystem::path& root() const { return roots.begin()->second; }

    std::filesystem::path pathOf(const std::string& name) const {
        return roots.at(name.substr(0, name.find('/'))) / name.substr(name.find('/') + 1);
    }
    std::filesystem::path output() const {
        auto path = pathOf(request.output());
        const auto file = path.filename();
        return path += ".partial-" + draftId, path / file;
    }
    std::filesystem::path draft() const { return fmt::format("{}.partial-{}", output().string(), getpid()); }
};

void report(const Fake& fake, double fraction, const std::string& phase) {
    mote::proto::JobProgress progress;
    progress.set_progress(fraction);
    progress.set_phase(phase);
    const auto line = mote::toJsonLine(progress) + "\n";
    if (write(fake.progress, line.data(), line.size()) < 0) _exit(90);
}

void tell(const char* what, bool worked) {
    fmt::print(stderr, "{}: {}\n", what, worked ? "allowed" : std::strerror(errno));
}

void makeWrong(const std::filesystem::path& output, const std::string& kind) {
    if (kind == "link") std::filesystem::create_symlink("/etc", output);
    if (kind == "pipe") mkfifo(output.c_str(), 0600);
    if (kind == "setuid") close(open(output.c_str(), O_WRONLY | O_CREAT, 04755));
    if (kind == "second") {
        std::ofstream(output) << "x";
        std::filesystem::create_hard_link(output, output.parent_path() / "second");
    }
    if (kind == "inside") {
        std::filesystem::create_directory(output);
        std::filesystem::create_symlink("/etc/passwd", output / "manifest.json");
    }
}

void act(const Fake& fake, const std::string& verb, const std::string& word) {
    if (attack(verb, word, fake.root().string())) return;
    if (verb == "phase") report(fake, 0.25, word);
    if (verb == "half") report(fake, 0.5, word);
    if (verb == "pids") report(fake, 0.1, fmt::format("{} {}", getpid(), getppid()));
    if (verb == "print") fmt::print(stderr, "{}\n", word);
    if (verb == "noise") fmt::print(stderr, "a\x01\xff\xc0\x80 b\xc3\xa9\n");
    if (verb == "ignore") signal(SIGTERM, SIG_IGN);
    if (verb == "draft") std::filesystem::create_directory(fake.draft());
    if (verb == "touch") tell("touch", open(word.c_str(), O_WRONLY | O_CREAT, 0600) >= 0);
    if (verb == "read") tell("read", open(word.c_str(), O_RDONLY) >= 0);
    if (verb == "input") {
        std::string line;
        std::getline(std::ifstream(fake.pathOf(fake.request.particles().inputs(0))), line);
        fmt::print(stderr, "input: {}\n", line);
    }
    if (verb == "socket") tell("socket", socket(AF_INET, SOCK_STREAM, 0) >= 0);
    if (verb == "unix") tell("unix", socket(AF_UNIX, SOCK_STREAM, 0) >= 0);
    if (verb == "connection") tell("connection", open(fake.connection.c_str(), O_RDONLY) >= 0);
    if (verb == "file") std::ofstream(fake.root() / word, std::ios::app) << 'x';
    if (verb == "full" && std::filesystem::exists(fake.root() / word)) {
        fmt::print(stderr, "no space left\n");
        _exit(EX_TEMPFAIL);
    }
    if (verb == "die") raise(std::stoi(word));
    if (verb == "exit") _exit(std::stoi(word));
    if (verb == "wait") {
        char byte = 0;
        const auto path = fake.root() / word;
        if (!fake.connection.empty()) mkfifo(path.c_str(), 0600);
        const int fifo = open(path.c_str(), O_RDONLY);
        if (read(fifo, &byte, 1) != 1) _exit(91);
    }
    if (verb == "publish") {
        std::filesystem::create_directory(fake.draft());
        std::filesystem::rename(fake.draft(), fake.output());
    }
    if (verb == "wrong") makeWrong(fake.output(), word);
    if (verb == "limits") {
        rlimit core{}, data{};
        getrlimit(RLIMIT_CORE, &core);
        getrlimit(RLIMIT_DATA, &data);
        fmt::print(stderr, "core {} data {} nice {} term {}\n", core.rlim_max, data.rlim_max,
                   getpriority(PRIO_PROCESS, 0), getpgid(0) == getpid());
        std::string session;
        std::getline(std::ifstream("/proc/self/autogroup"), session);
        if (!session.empty()) fmt::print(stderr, "session{}\n", session.substr(session.find(' ')));
    }
    std::fflush(stderr);
}

}  // namespace

int main(int argc, char** argv) {
    Fake fake;
    const bool film = argc > 2 && std::string(argv[1]) == "--job";
    if (argc < 3 || (!film && std::string(argv[1]) != "job")) return 92;
    if (film) fake.roots["film"] = std::filesystem::path(argv[2]).parent_path() / "film";
    for (int i = 3; i + 1 < argc; i += 2) {
        const std::string option(argv[i]), value(argv[i + 1]);
        if (option == "--root")
            fake.roots[value.substr(0, value.find('='))] = value.substr(value.find('=') + 1);
        // What it makes stays in a folder of the job's own, as a film.
        if (option == "--output") {
            fake.roots = {{"export", std::filesystem::path(value).parent_path()}};
            fake.connection = value;
        }
        if (option == "--draft") fake.draftId = value;
        if (option == "--connect") fake.connection = value;
        if (option == "--progress-fd") fake.progress = std::stoi(value);
    }
    if (!mote::readJsonFile(argv[2], fake.request).ok()) return 93;
    std::istringstream words(fake.request.title());
    for (std::string word; words >> word;) {
        const auto colon = word.find(':');
        act(fake, word.substr(0, colon), word.substr(colon + 1));
    }
    return 0;
}
