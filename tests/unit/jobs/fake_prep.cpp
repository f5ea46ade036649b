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
//                  pipe, set-uid, has a second name, or holds a link (fake_attacks.h has other misdeeds)
#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sysexits.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>

#include "protocol/mote.pb.h"
#include "protocol/scene/json.h"
#include "tests/unit/jobs/fake_attacks.h"

namespace {

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
