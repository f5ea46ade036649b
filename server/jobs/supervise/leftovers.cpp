// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/supervise/supervise.h"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cctype>
#include <cerrno>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <string>

namespace mote::server {
namespace {

/// The parent of a process; 0 where it has gone.
pid_t parentOf(const std::filesystem::path& process) {
    std::string text;
    std::getline(std::ifstream(process / "stat"), text);
    const auto name = text.rfind(')');  // of the program, which may hold anything
    pid_t parent = 0;
    if (name == std::string::npos || name + 4 > text.size()) return 0;
    std::from_chars(text.data() + name + 4, text.data() + text.size(), parent);  // behind ") S "
    return parent;
}

void killChildren() {
    std::error_code code;
    for (std::filesystem::directory_iterator entry("/proc", code), end; !code && entry != end;
         entry.increment(code)) {
        const auto name = entry->path().filename().string();
        pid_t number = 0;
        if (std::from_chars(name.data(), name.data() + name.size(), number).ec != std::errc()) continue;
        // Nobody else gets the number of a child that is not waited for.
        if (parentOf(entry->path()) == getpid()) kill(number, SIGKILL);
    }
}

}  // namespace

void adoptLeftovers() {
    prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0);
}

void killLeftovers() {
    while (true) {
        const pid_t ended = waitpid(-1, nullptr, WNOHANG);
        if (ended > 0 || (ended < 0 && errno == EINTR)) continue;
        if (ended < 0) return;  // there are none
        killChildren();
        waitpid(-1, nullptr, 0);
    }
}

}  // namespace mote::server
