// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/files/walk_folders.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>

#include <cerrno>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "storage/files/file_descriptor.h"

namespace mote::storage {
namespace {

namespace fs = std::filesystem;

struct CloseFolder {
    void operator()(DIR* folder) const { ::closedir(folder); }
};
using Folder = std::unique_ptr<DIR, CloseFolder>;

/// The last part of the path is not followed where it is a link: a folder may have been put in place of one
/// since it was listed.
Folder openFolder(const fs::path& path, bool followed) {
    const int file = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC | (followed ? 0 : O_NOFOLLOW));
    if (file < 0) return nullptr;
    Folder folder(::fdopendir(file));
    if (!folder) ::close(file);
    return folder;
}

bool isFolder(DIR* folder, const dirent& entry) {
    if (entry.d_type != DT_UNKNOWN) return entry.d_type == DT_DIR;
    struct stat status {};
    return ::fstatat(::dirfd(folder), entry.d_name, &status, AT_SYMLINK_NOFOLLOW) == 0 &&
           S_ISDIR(status.st_mode);
}

bool isPassedOver(int error) {
    return error == ENOENT || error == EACCES || error == ELOOP || error == ENOTDIR;
}

class Walker {
  public:
    Walker(const fs::path& top, const FolderWalk& walk) : top_(top), walk_(walk) { enter({{}, 0}); }

    void run() {
        while (!waiting_.empty() && !stopped_) {
            const auto next = std::move(waiting_.back());
            waiting_.pop_back();
            enter(next);
        }
    }

  private:
    struct Place {
        fs::path relative;
        int depth;
    };

    void enter(const Place& place) {
        const auto folder = openFolder(top_ / place.relative, place.relative.empty());
        if (!folder) {
            // Of the first one nobody knows that it is gone.
            if (place.relative.empty() || !isPassedOver(errno)) walk_.unreadable(place.relative, errno);
            return;
        }
        for (;;) {
            errno = 0;
            const dirent* entry = ::readdir(folder.get());
            if (!entry) break;
            const std::string_view name = entry->d_name;
            if (name == "." || name == "..") continue;
            if (!walk_.count()) stopped_ = true;
            if (!stopped_ && isFolder(folder.get(), *entry)) show({place.relative / name, place.depth});
            if (stopped_) return;
        }
        if (errno != 0 && !isPassedOver(errno)) walk_.unreadable(place.relative, errno);
    }

    void show(Place place) {
        const auto next = walk_.visit(place.relative);
        stopped_ = next == FolderWalk::Next::stop;
        if (next != FolderWalk::Next::enter || place.depth >= walk_.maxDepth) return;
        ++place.depth;
        waiting_.push_back(std::move(place));
    }

    const fs::path& top_;
    const FolderWalk& walk_;
    std::vector<Place> waiting_;
    bool stopped_ = false;
};

}  // namespace

void walkFolders(const fs::path& top, const FolderWalk& walk) {
    Walker(top, walk).run();
}

}  // namespace mote::storage
