// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/disk_work.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdio.h>
#include <sys/random.h>

#include <asio/post.hpp>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "server/jobs/job_inputs.h"
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

/// Of the job with this id, whose output is to lie there (a real path).
fs::path draftOf(const fs::path& output, std::string_view job) {
    return fmt::format("{}.partial-{}", output.string(), job);
}

/// Its new name; empty: there is no draft.
fs::path setDraftAside(const fs::path& output, std::string_view job) {
    const auto draft = draftOf(output, job);
    const auto folder = openFolder(draft.parent_path());
    if (!folder) return {};
    const fs::path aside = fmt::format("{}{}{}", draft.string(), kAside, randomWord());
    const int renamed =
        ::renameat(folder->get(), draft.filename().c_str(), folder->get(), aside.filename().c_str());
    return renamed == 0 ? aside : fs::path();
}

void sweepFolders(const storage::Roots& roots, const std::vector<DraftOwner>& owners) {
    std::map<fs::path, Wanted> folders;
    for (const auto& [name, job, live] : owners) {
        proto::JobRequest request;
        request.set_output(name);
        const auto output = findOutput(request, roots);
        if (!output.ok()) continue;
        auto& wanted = folders[output->path.parent_path()];
        (live ? wanted.live : wanted.dead).insert(draftOf(output->path, job).filename().string());
    }
    for (const auto& [folder, wanted] : folders) sweepFolder(folder, wanted);
}

}  // namespace

DiskWork::~DiskWork() {
    thread_.stop();
    thread_.join();
}

void DiskWork::post(std::function<void()> work) {
    asio::post(thread_, std::move(work));
}

void DiskWork::remove(const fs::path& folder) {
    post([folder] {
        std::error_code code;
        fs::remove_all(folder, code);
    });
}

void DiskWork::removeDraft(const fs::path& output, const std::string& job) {
    const auto aside = setDraftAside(output, job);
    if (aside.empty()) return;
    // Whatever became of its parents' names meanwhile.
    post([aside] {
        const auto folder = openFolder(aside.parent_path());
        std::error_code code;
        if (folder) fs::remove_all(nameOf(*folder) / aside.filename(), code);
    });
}

void DiskWork::sweepDrafts(const storage::Roots& roots, std::vector<DraftOwner> owners) {
    post([roots, owners = std::move(owners)] { sweepFolders(roots, owners); });
}

}  // namespace mote::server
