// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/look/list_folder.h"

#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <memory>
#include <string>
#include <vector>

#include "protocol/base/system_error.h"
#include "protocol/base/utf8.h"
#include "storage/files/real_path.h"
#include "storage/manifest.h"

namespace mote::server {
namespace {

using storage::FileDescriptor;

struct Name {
    std::string name;
    proto::Folder::Kind kind;
    std::filesystem::path real = {};  ///< of a link: where it leads
};

/// What is left out of a folder, by its reason.
struct LeftOut {
    std::size_t notText = 0, links = 0, others = 0;
    bool more = false;  ///< names that were not read

    void tell(proto::Folder& folder) const {
        const auto say = [&](std::size_t count, const char* one, const char* several) {
            if (count > 0) folder.add_notes(count == 1 ? one : fmt::format("{} {}", count, several));
        };
        say(notText, "a name that is not UTF-8 is left out", "names that are not UTF-8 are left out");
        say(links, "a link that leads out of the root, or nowhere, is left out",
            "links that lead out of the root, or nowhere, are left out");
        say(others, "something that is neither a file nor a folder is left out",
            "things that are neither files nor folders are left out");
        if (more) {
            folder.add_notes(fmt::format(
                "the folder holds more than {} names, of which the others are left out", mostFolderNames));
        }
    }
};

std::int64_t milliseconds(const timespec& time) {
    return std::int64_t{time.tv_sec} * 1000 + time.tv_nsec / 1'000'000;
}

/// Drafts come and go while jobs run.
bool isDraft(std::string_view name) {
    return name.find(std::string(storage::datasetSuffix) + ".partial-") != std::string_view::npos;
}

/// An open folder and what it is called, "ROOT/PATH".
class FolderReader {
  public:
    FolderReader(const storage::Roots& roots, std::string name) : roots_(roots), name_(std::move(name)) {}

    Status open() {
        MOTE_ASSIGN_OR_RETURN(const auto path, roots_.resolveExisting(name_));
        struct stat status {};
        if (::stat(path.c_str(), &status) == 0 && !S_ISDIR(status.st_mode))
            return invalid(name_, "is not a folder");
        auto opened = storage::openReal(path, O_RDONLY | O_DIRECTORY | O_NONBLOCK);
        // The path of this machine is nobody's business.
        if (!opened.ok()) return Error{opened.error().code, name_, opened.error().message};
        folder_ = *std::move(opened);
        return success();
    }

    Result<std::vector<Name>> names(LeftOut& leftOut) const {
        const std::unique_ptr<DIR, int (*)(DIR*)> listed(::fdopendir(::dup(folder_.get())), ::closedir);
        if (!listed) return systemError(errno, name_, "cannot be listed");
        std::vector<Name> names;
        errno = 0;
        while (const dirent* const entry = ::readdir(listed.get())) {
            if (names.size() == mostFolderNames) {
                leftOut.more = true;
                return names;
            }
            take(*entry, names, leftOut);
            errno = 0;
        }
        if (errno != 0) return systemError(errno, name_, "cannot be listed");
        return names;
    }

    /// Size and time of what is listed; nothing of what has gone meanwhile.
    void describe(const Name& name, proto::Folder::Entry& entry) const {
        entry.set_name(name.name);
        entry.set_kind(name.kind);
        struct stat status {};
        const int failed = name.real.empty()
                               ? ::fstatat(folder_.get(), name.name.c_str(), &status, AT_SYMLINK_NOFOLLOW)
                               : ::lstat(name.real.c_str(), &status);
        if (failed != 0) return;
        entry.set_changed_ms(milliseconds(status.st_mtim));
        if (S_ISREG(status.st_mode)) entry.set_bytes(static_cast<std::uint64_t>(status.st_size));
    }

  private:
    void take(const dirent& entry, std::vector<Name>& names, LeftOut& leftOut) const {
        const std::string_view name(entry.d_name);
        if (name.starts_with('.') || isDraft(name)) return;
        if (!isUtf8(name)) {
            ++leftOut.notText;
            return;
        }
        Name found{std::string(name), proto::Folder::FILE};
        auto mode = modeOf(entry);
        if (S_ISLNK(mode)) {
            const auto real = roots_.resolveExisting(name_ + "/" + found.name);
            struct stat status {};
            if (!real.ok() || ::lstat(real->c_str(), &status) != 0) {
                ++leftOut.links;
                return;
            }
            found.real = *real;
            mode = status.st_mode;
        }
        if (S_ISDIR(mode)) {
            found.kind = isDataset(found.name) ? proto::Folder::DATASET : proto::Folder::FOLDER;
        } else if (!S_ISREG(mode)) {
            ++leftOut.others;
            return;
        }
        names.push_back(std::move(found));
    }

    mode_t modeOf(const dirent& entry) const {
        if (entry.d_type != DT_UNKNOWN) return DTTOIF(entry.d_type);
        struct stat status {};
        const bool known = ::fstatat(folder_.get(), entry.d_name, &status, AT_SYMLINK_NOFOLLOW) == 0;
        return known ? status.st_mode : 0;
    }

    bool isDataset(const std::string& name) const {
        return name.ends_with(storage::datasetSuffix) &&
               ::faccessat(folder_.get(), (name + "/manifest.json").c_str(), F_OK, 0) == 0;
    }

    const storage::Roots& roots_;
    const std::string name_;
    FileDescriptor folder_;
};

proto::Folder listRoots(const storage::Roots& roots) {
    proto::Folder folder;
    for (const auto& root : roots.entries()) {
        auto& entry = *folder.add_entries();
        entry.set_name(root.name);
        entry.set_kind(proto::Folder::FOLDER);
        struct stat status {};
        if (::stat(root.folder.c_str(), &status) == 0) entry.set_changed_ms(milliseconds(status.st_mtim));
    }
    folder.set_total(static_cast<std::uint64_t>(folder.entries_size()));
    return folder;
}

bool isDigit(char letter) {
    return letter >= '0' && letter <= '9';
}

/// Takes the digits that a text begins with, without leading zeros.
std::string_view takeNumber(std::string_view& text) {
    std::size_t end = 0;
    while (end < text.size() && isDigit(text[end])) ++end;
    auto number = text.substr(0, end);
    text.remove_prefix(end);
    number.remove_prefix(std::min(number.find_first_not_of('0'), number.size()));
    return number;
}

char small(char letter) {
    return letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter - 'A' + 'a') : letter;
}

}  // namespace

bool standsBefore(std::string_view one, std::string_view other) {
    auto left = one, right = other;
    while (!left.empty() && !right.empty()) {
        if (isDigit(left[0]) && isDigit(right[0])) {
            const auto a = takeNumber(left), b = takeNumber(right);
            if (a.size() != b.size()) return a.size() < b.size();
            if (a != b) return a < b;
            continue;
        }
        const auto a = static_cast<unsigned char>(small(left[0])),
                   b = static_cast<unsigned char>(small(right[0]));
        if (a != b) return a < b;
        left.remove_prefix(1);
        right.remove_prefix(1);
    }
    if (left.empty() != right.empty()) return left.empty();
    return one < other;
}

Result<proto::Folder> listFolder(const proto::ListFolder& wanted, const storage::Roots& roots) {
    if (wanted.folder().empty()) return listRoots(roots);
    FolderReader reader(roots, wanted.folder());
    MOTE_RETURN_IF_ERROR(reader.open());
    LeftOut leftOut;
    MOTE_ASSIGN_OR_RETURN(auto names, reader.names(leftOut));
    std::ranges::sort(names, [](const Name& one, const Name& other) {
        const bool folder = one.kind == proto::Folder::FOLDER,
                   otherFolder = other.kind == proto::Folder::FOLDER;
        return folder != otherFolder ? folder : standsBefore(one.name, other.name);
    });
    proto::Folder folder;
    folder.set_folder(wanted.folder());
    folder.set_total(names.size());
    const auto first = std::min<std::uint64_t>(wanted.first(), names.size());
    folder.set_first(first);
    const std::uint64_t count =
        wanted.count() == 0 ? mostListed : std::min<std::uint64_t>(wanted.count(), mostListed);
    const auto end = std::min<std::uint64_t>(first + count, names.size());
    for (auto i = first; i < end; ++i) reader.describe(names[i], *folder.add_entries());
    leftOut.tell(folder);
    return folder;
}

}  // namespace mote::server
