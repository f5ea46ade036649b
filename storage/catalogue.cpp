// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/catalogue.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>

#include "protocol/scene/dataset.h"
#include "protocol/scene/system_error.h"
#include "storage/files/walk_folders.h"
#include "storage/manifest.h"

namespace mote::storage {

namespace fs = std::filesystem;

/// What one refresh has found so far.
struct Catalogue::Walk {
    std::vector<Entry> entries;
    std::vector<Error> errors;
    std::map<fs::path, Cached> cache;
    std::size_t visited = 0;
    bool full = false;

    void fail(Error error) {
        if (errors.size() < 100) errors.push_back(std::move(error));
    }
};

namespace {

bool isDataset(const fs::path& path) {
    return path.extension() == datasetSuffix && path.stem() != "";
}

/// What a job makes a dataset in (dataset_writer.h): nothing in it is one.
bool isDraft(const fs::path& path) {
    return path.filename().string().find(std::string(datasetSuffix) + ".partial-") != std::string::npos;
}

std::string_view withoutSuffix(std::string_view name) {
    const std::string_view suffix = datasetSuffix;
    if (name.ends_with(suffix)) name.remove_suffix(suffix.size());
    return name;
}

bool sameEntry(const Catalogue::Entry& a, const Catalogue::Entry& b) {
    return a.name == b.name && a.directory == b.directory && a.manifest == b.manifest;
}

}  // namespace

bool Catalogue::refresh() {
    Walk walk;
    for (const auto& root : roots_.entries()) walkRoot(root, walk);
    std::sort(walk.entries.begin(), walk.entries.end(),
              [](const Entry& a, const Entry& b) { return a.name < b.name; });
    // A folder that is renamed while its parent is listed may be seen twice.
    walk.entries.erase(std::unique(walk.entries.begin(), walk.entries.end(),
                                   [](const Entry& a, const Entry& b) { return a.name == b.name; }),
                       walk.entries.end());
    const bool changed =
        !std::equal(entries_.begin(), entries_.end(), walk.entries.begin(), walk.entries.end(), sameEntry);
    entries_ = std::move(walk.entries);
    errors_ = std::move(walk.errors);
    cache_ = std::move(walk.cache);
    return changed;
}

void Catalogue::walkRoot(const Roots::Entry& root, Walk& walk) {
    using Next = FolderWalk::Next;
    FolderWalk folders;
    folders.maxDepth = maxDepth;
    folders.count = [&] {
        if (walk.entries.size() < maxDatasets && ++walk.visited <= maxVisited) return true;
        if (!std::exchange(walk.full, true)) {
            walk.fail({ErrorCode::resourceExhausted, root.name,
                       fmt::format("the catalogue stops at {} datasets and {} files and folders", maxDatasets,
                                   maxVisited)});
        }
        return false;
    };
    folders.visit = [&](const fs::path& folder) {
        if (isDraft(folder)) return Next::pass;
        if (!isDataset(folder)) return Next::enter;
        const auto relative = folder.generic_string();
        addDataset(root.folder / folder, root.name + "/" + std::string(withoutSuffix(relative)), walk);
        return Next::pass;
    };
    folders.unreadable = [&](const fs::path& folder, int error) {
        walk.fail(systemError(error, (root.name / folder).generic_string(), "its folders cannot be listed"));
    };
    walkFolders(root.folder, folders);
}

/// False, and errno, where there is none: its stamp is that of nothing then.
bool Catalogue::look(const fs::path& file, Stamp& stamp) {
    struct stat status {};
    if (::lstat(file.c_str(), &status) != 0) return false;
    stamp = {status.st_dev,         status.st_ino,          static_cast<std::uint64_t>(status.st_size),
             status.st_mtim.tv_sec, status.st_mtim.tv_nsec, status.st_ctim.tv_sec,
             status.st_ctim.tv_nsec};
    return true;
}

void Catalogue::addDataset(const fs::path& directory, std::string name, Walk& walk) {
    Stamp stamp, digest;
    look(directory / manifestDigestName, digest);  // a dataset may have none
    if (!look(directory / manifestName, stamp)) {
        const int error = errno;
        std::error_code code;
        if (error == ENOENT && !fs::exists(directory, code)) return;  // it went while it was looked at
        return walk.fail(systemError(error, name, "its manifest.json cannot be read"));
    }
    auto known = cache_.find(directory);
    if (known == cache_.end() || !(known->second.stamp == stamp && known->second.digest == digest)) {
        auto read = readManifest(directory);
        using Shared = std::shared_ptr<const proto::Manifest>;
        auto shared = read.ok() ? Result<Shared>(std::make_shared<const proto::Manifest>(*std::move(read)))
                                : Result<Shared>(read.error());
        known = cache_.insert_or_assign(directory, Cached{stamp, digest, std::move(shared)}).first;
    }
    const auto& cached = walk.cache.insert_or_assign(directory, known->second).first->second;
    if (!cached.manifest.ok()) return walk.fail(cached.manifest.error());
    walk.entries.push_back({std::move(name), directory, *cached.manifest});
}

const Catalogue::Entry* Catalogue::find(std::string_view name) const {
    const auto wanted = withoutSuffix(name);
    const auto found =
        std::lower_bound(entries_.begin(), entries_.end(), wanted,
                         [](const Entry& entry, std::string_view text) { return entry.name < text; });
    return found != entries_.end() && found->name == wanted ? &*found : nullptr;
}

proto::Catalogue Catalogue::summary() const {
    proto::Catalogue message;
    for (const auto& entry : entries_) {
        auto& dataset = *message.add_datasets();
        dataset.set_name(entry.name);
        dataset.set_kind(entry.manifest->kind());
        dataset.set_title(entry.manifest->title());
        dataset.set_steps(static_cast<std::uint32_t>(stepCount(*entry.manifest)));
        std::uint64_t most = 0;
        for (const auto& step : entry.manifest->particles().steps()) most = std::max(most, step.particles());
        dataset.set_particles(most);
    }
    return message;
}

}  // namespace mote::storage
