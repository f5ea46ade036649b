// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/orbit/server_watch.h"

#include <fmt/format.h>
#include <unistd.h>

#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

namespace mote::bench {
namespace {

std::string textOf(pid_t process, const char* name) {
    std::ifstream file(fmt::format("/proc/{}/{}", process, name));
    std::ostringstream text;
    text << file.rdbuf();
    if (text.str().empty()) throw std::runtime_error(fmt::format("there is no process {}", process));
    return text.str();
}

std::uint64_t kibibytes(const std::string& status, const std::string& field) {
    const auto at = status.find(field + ":");
    return at == std::string::npos ? 0 : std::stoull(status.substr(at + field.size() + 1)) << 10;
}

}  // namespace

std::chrono::duration<double> processorTime(pid_t process) {
    const std::string text = textOf(process, "stat");
    std::istringstream words(text.substr(text.rfind(')') + 2));  // behind the name, which may hold anything
    std::string skipped;
    for (int i = 0; i < 11; ++i) words >> skipped;
    double user = 0.0, system = 0.0;
    words >> user >> system;
    return std::chrono::duration<double>((user + system) / static_cast<double>(::sysconf(_SC_CLK_TCK)));
}

Memory residentMemory(pid_t process) {
    const std::string status = textOf(process, "status");
    return {kibibytes(status, "RssAnon"), kibibytes(status, "RssFile") + kibibytes(status, "RssShmem")};
}

}  // namespace mote::bench
