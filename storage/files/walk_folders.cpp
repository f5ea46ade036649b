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
#include "storage/files/real_path.h"

namespace mote::storage {
namespace {

namespace fs = std::filesystem;

struct CloseFolder {
    void operator()(DIR* folder) const { ::closedir(folder); }
};
using Folder = std::unique_ptr<DIR, CloseFolder>;

/// No part of the path is followed if it is a link: one may have been put in a folder's place since that
/// was listed.
Folder openFolder(int top, const fs::path& path) {
    FileDescriptor file = openRealAt(top, path.empty() ? "." : path, O_RDONLY | O_DIRECTORY);
    Folder folder(file.valid() ? ::fdopendir(file.get()) : nullptr);
    if (folder) file.release();
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
    Walker(const fs::path& top, const FolderWalk& walk)
        : top_(::open(top.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)), walk_(walk) {
        if (top_.valid()) {
            enter({{}, 0});
        } else {
            walk_.unreadable({}, errno);
        }
    }

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
        const auto folder = openFolder(top_.get(), place.relative);
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

    const FileDescriptor top_;
    const FolderWalk& walk_;
    std::vector<Place> waiting_;
    bool stopped_ = false;
};

}  // namespace

void walkFolders(const fs::path& top, const FolderWalk& walk) {
    Walker(top, walk).run();
}

}  // namespace mote::storage
