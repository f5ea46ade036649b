// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/catalogue.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>

#include "protocol/base/system_error.h"
#include "protocol/scene/dataset.h"
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

/// Why a folder that was listed cannot be opened: it went, or something else took its place.
bool isGone(int error) {
    return error == ENOENT || error == ENOTDIR || error == ELOOP;
}

bool sameEntry(const Catalogue::Entry& a, const Catalogue::Entry& b) {
    return a.name == b.name && a.directory == b.directory && a.manifest == b.manifest &&
           a.manifestWritten == b.manifestWritten;
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
        addDataset({root.folder, folder}, root.name + "/" + std::string(withoutSuffix(relative)), walk);
        return Next::pass;
    };
    folders.unreadable = [&](const fs::path& folder, int error) {
        walk.fail(systemError(error, (root.name / folder).generic_string(), "its folders cannot be listed"));
    };
    walkFolders(root.folder, folders);
}

/// What the place is to blame for may have passed, and no stamp tells of that.
bool Catalogue::Cached::holds(const Stamp& now, const Stamp& digestNow) const {
    const auto ofThePlace = [](const Error& why) { return why.passing || why.code == ErrorCode::internal; };
    return stamp == now && digest == digestNow && (manifest.ok() || !ofThePlace(manifest.error()));
}

/// False, and errno, if there is none: its stamp is that of nothing then.
bool Catalogue::look(const FileDescriptor& directory, const char* file, Stamp& stamp) {
    struct stat status {};
    if (::fstatat(directory.get(), file, &status, AT_SYMLINK_NOFOLLOW) != 0) return false;
    stamp = {status.st_dev,         status.st_ino,          static_cast<std::uint64_t>(status.st_size),
             status.st_mtim.tv_sec, status.st_mtim.tv_nsec, status.st_ctim.tv_sec,
             status.st_ctim.tv_nsec};
    return true;
}

void Catalogue::addDataset(const PathBeneath& directory, std::string name, Walk& walk) {
    Stamp stamp, digest;
    const auto folder = directory.open(O_PATH | O_DIRECTORY);
    if (!folder.valid() && isGone(errno)) return;
    if (!folder.valid() || !look(folder, manifestName, stamp)) {
        const int error = errno;
        if (error == ENOENT && !directory.open(O_PATH | O_DIRECTORY).valid()) return;  // it went meanwhile
        return walk.fail(systemError(error, name, "its manifest.json cannot be read"));
    }
    look(folder, manifestDigestName, digest);  // a dataset may have none
    auto known = cache_.find(directory.path());
    if (known == cache_.end() || !known->second.holds(stamp, digest)) {
        auto read = readManifest(PathBeneath::in(folder, directory.path()));
        using Shared = std::shared_ptr<const proto::Manifest>;
        auto shared = read.ok() ? Result<Shared>(std::make_shared<const proto::Manifest>(*std::move(read)))
                                : Result<Shared>(read.error());
        known = cache_.insert_or_assign(directory.path(), Cached{stamp, digest, std::move(shared)}).first;
    }
    const auto& cached = walk.cache.insert_or_assign(directory.path(), known->second).first->second;
    if (!cached.manifest.ok()) return walk.fail(cached.manifest.error());
    walk.entries.push_back({std::move(name), directory, *cached.manifest, stamp.size,
                            1000 * stamp.seconds + stamp.nanoseconds / 1'000'000});
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
        dataset.set_live(entry.manifest->particles().live());
        std::uint64_t bytes = entry.manifestBytes;
        for (const auto& file : entry.manifest->files()) bytes += file.size();
        dataset.set_bytes(bytes);
        dataset.set_prepared_ms(entry.manifestWritten);
    }
    return message;
}

}  // namespace mote::storage
