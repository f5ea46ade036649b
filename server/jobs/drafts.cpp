// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/drafts.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdio.h>
#include <sys/random.h>

#include <cstdint>
#include <map>
#include <optional>
#include <set>

#include "storage/files/real_path.h"

namespace mote::server {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kAside = ".gone-";

/// The folder of a draft, which is no link, under a name that means it for as long as it is open.
std::optional<storage::FileDescriptor> openFolder(const fs::path& folder) {
    auto opened = storage::openReal(folder, O_RDONLY | O_DIRECTORY);
    return opened.ok() ? std::optional(*std::move(opened)) : std::nullopt;
}

fs::path nameOf(const storage::FileDescriptor& folder) {
    return fmt::format("/proc/self/fd/{}", folder.get());
}

std::string randomWord() {
    std::uint64_t bits = 0;
    return ::getrandom(&bits, sizeof bits, 0) == sizeof bits ? fmt::format("{:016x}", bits) : "0";
}

/// Names of live jobs' drafts, and of those that are not.
struct Wanted {
    std::set<std::string> live, dead;

    bool isStale(std::string name) const {
        const auto aside = name.rfind(kAside);
        const bool set = aside != std::string::npos;
        if (set) name.resize(aside);
        return dead.contains(name) || (set && live.contains(name));
    }
};

void sweepFolder(const fs::path& path, const Wanted& wanted) {
    const auto folder = openFolder(path);
    if (!folder) return;
    std::vector<fs::path> stale;
    std::error_code code;
    fs::directory_iterator entry(nameOf(*folder), code);
    for (; !code && entry != fs::directory_iterator(); entry.increment(code)) {
        if (wanted.isStale(entry->path().filename().string())) stale.push_back(entry->path());
    }
    for (const auto& draft : stale) fs::remove_all(draft, code);
}

}  // namespace

fs::path draftOf(const fs::path& output, std::string_view job) {
    return fmt::format("{}.partial-{}", output.string(), job);
}

fs::path setDraftAside(const fs::path& output, std::string_view job) {
    const auto draft = draftOf(output, job);
    const auto folder = openFolder(draft.parent_path());
    if (!folder) return {};
    const fs::path aside = fmt::format("{}{}{}", draft.string(), kAside, randomWord());
    const int renamed =
        ::renameat(folder->get(), draft.filename().c_str(), folder->get(), aside.filename().c_str());
    return renamed == 0 ? aside : fs::path();
}

void removeDraft(const fs::path& draft) {
    const auto folder = openFolder(draft.parent_path());
    std::error_code code;
    if (folder) fs::remove_all(nameOf(*folder) / draft.filename(), code);
}

void sweepDrafts(const std::vector<DraftOwner>& owners) {
    std::map<fs::path, Wanted> folders;
    for (const auto& [output, job, live] : owners) {
        auto& wanted = folders[output.parent_path()];
        (live ? wanted.live : wanted.dead).insert(draftOf(output, job).filename().string());
    }
    for (const auto& [folder, wanted] : folders) sweepFolder(folder, wanted);
}

}  // namespace mote::server
