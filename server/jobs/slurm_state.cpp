// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/slurm_state.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

namespace mote::server {
namespace {

/// Cuts off what stands before the next `end`, and this.
std::string_view take(std::string_view& text, char end) {
    const auto at = std::min(text.find(end), text.size());
    const auto taken = text.substr(0, at);
    text.remove_prefix(std::min(at + 1, text.size()));
    return taken;
}

// Of all others something runs, or will: PENDING, CONFIGURING, RUNNING, SUSPENDED, COMPLETING and their kin.
constexpr std::array<std::string_view, 10> kEnded{"COMPLETED", "CANCELLED", "FAILED",        "TIMEOUT",
                                                  "NODE_FAIL", "PREEMPTED", "OUT_OF_MEMORY", "BOOT_FAIL",
                                                  "DEADLINE",  "REVOKED"};

}  // namespace

std::optional<std::uint64_t> parseNumber(std::string_view text) {
    std::uint64_t number = 0;
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (code != std::errc() || number == 0) return std::nullopt;
    const auto rest = text.substr(static_cast<std::size_t>(end - text.data()));
    return rest.empty() || rest.front() == ';' || rest.front() == '\n' ? std::optional(number) : std::nullopt;
}

std::map<std::uint64_t, SlurmState> parseQueue(std::string_view lines) {
    std::map<std::uint64_t, SlurmState> jobs;
    while (!lines.empty()) {
        auto line = take(lines, '\n');
        const auto number = parseNumber(take(line, '|'));
        const auto state = take(line, '|');
        if (number && !state.empty()) jobs[*number] = {std::string(state), std::string(line)};
    }
    return jobs;
}

std::multimap<std::string, std::uint64_t> parseNames(std::string_view lines) {
    std::multimap<std::string, std::uint64_t> names;
    while (!lines.empty()) {
        auto line = take(lines, '\n');
        if (const auto number = parseNumber(take(line, '|'))) names.emplace(line, *number);
    }
    return names;
}

bool hasEnded(std::string_view state) {
    return std::ranges::find(kEnded, state) != kEnded.end();
}

RunEnd endOf(std::string_view state) {
    if (state.starts_with("TIMEOUT")) return {"ran longer than Slurm let it", false};
    if (state.starts_with("DEADLINE")) return {"ran into a deadline of Slurm's", false};
    if (state.starts_with("OUT_OF_ME")) return {"took more memory than Slurm gave it", false};
    if (state.starts_with("CANCELLED")) return {"was cancelled in Slurm", false};
    if (state.starts_with("NODE_FAIL")) return {"its node went down", true};
    if (state.starts_with("PREEMPTED")) return {"Slurm needed its place for another job", true};
    return {};
}

}  // namespace mote::server
