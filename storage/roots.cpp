// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/roots.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/openat2.h>
#include <sys/stat.h>
#include <sys/syscall.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <set>
#include <utility>

#include "protocol/base/system_error.h"
#include "storage/files/file_descriptor.h"
#include "storage/files/real_path.h"

namespace mote::storage {
namespace {

namespace fs = std::filesystem;

Error invalid(std::string_view name, std::string message) {
    return {ErrorCode::invalidArgument, std::string(name.substr(0, 200)), std::move(message)};
}

bool isRootName(std::string_view name) {
    const auto allowed = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
               c == '-';
    };
    return !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), allowed);
}

/// The part of "ROOT/PATH" behind the root's name, checked: relative, without empty, "." and ".." parts.
Result<std::string> checkedPath(std::string_view whole, std::string_view path) {
    if (whole.size() >= PATH_MAX) return invalid(whole, "is longer than a path may be");
    if (whole.find('\0') != std::string_view::npos) return invalid(whole, "holds a zero byte");
    std::string_view rest = path;
    while (!rest.empty()) {
        const auto slash = rest.find('/');
        const auto part = rest.substr(0, slash);
        if (part.empty() || part == "." || part == "..") {
            return invalid(whole, "must be \"ROOT/PATH\" without empty, \".\" or \"..\" parts");
        }
        if (slash == std::string_view::npos) break;
        rest.remove_prefix(slash + 1);
        if (rest.empty()) return invalid(whole, "must not end with \"/\"");
    }
    return std::string(path);
}

struct Place {
    const Roots::Entry* root;
    std::string path;  ///< relative to the root's folder; "" is the folder itself
};

Result<Place> locate(const std::vector<Roots::Entry>& entries, std::string_view name) {
    const auto slash = name.find('/');
    const auto rootName = name.substr(0, slash);
    if (!isRootName(rootName)) return invalid(name, "must be \"ROOT/PATH\", the root a configured name");
    MOTE_ASSIGN_OR_RETURN(auto path,
                          checkedPath(name, slash == std::string_view::npos ? "" : name.substr(slash + 1)));
    if (slash != std::string_view::npos && path.empty()) return invalid(name, "must not end with \"/\"");
    const auto found = std::find_if(entries.begin(), entries.end(),
                                    [&](const Roots::Entry& entry) { return entry.name == rootName; });
    if (found != entries.end()) return Place{&*found, path};
    std::string known;
    for (const auto& entry : entries) known += (known.empty() ? "" : ", ") + entry.name;
    return Error{ErrorCode::notFound, std::string(name.substr(0, 200)),
                 fmt::format("there is no root of that name; roots are: {}", known.empty() ? "none" : known)};
}

Result<FileDescriptor> openBeneath(const Place& place, std::string_view name, std::uint64_t flags) {
    const FileDescriptor folder(::open(place.root->folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
    if (!folder.valid()) return systemError(errno, std::string(name), "the root's folder cannot be opened");
    open_how how{};
    how.flags = flags | O_PATH | O_CLOEXEC;
    how.resolve = RESOLVE_BENEATH | RESOLVE_NO_MAGICLINKS;
    const std::string path = place.path.empty() ? "." : place.path;
    // EAGAIN: something was renamed meanwhile and the kernel cannot be sure.
    for (int attempt = 0; attempt < 16; ++attempt) {
        const long opened = ::syscall(SYS_openat2, folder.get(), path.c_str(), &how, sizeof how);
        if (opened >= 0) return FileDescriptor(static_cast<int>(opened));
        if (errno != EAGAIN && errno != EINTR) break;
    }
    if (errno == ENOSYS) {
        auto walked = walkRealAt(folder.get(), path, static_cast<int>(how.flags));
        if (walked.valid()) return walked;
    }
    const int number = errno;
    if (number == EXDEV) return invalid(name, "leads out of its root by a link");
    if (number == ELOOP) return invalid(name, "leads through too many or forbidden links");
    return systemError(number, std::string(name), "cannot be found beneath its root");
}

Result<fs::path> pathOf(const FileDescriptor& file, std::string_view name) {
    std::array<char, PATH_MAX> target{};
    const auto link = fmt::format("/proc/self/fd/{}", file.get());
    const ssize_t length = ::readlink(link.c_str(), target.data(), target.size());
    if (length < 0) return systemError(errno, std::string(name), "its real path cannot be read");
    if (static_cast<std::size_t>(length) == target.size()) return invalid(name, "has too long a real path");
    return fs::path(std::string(target.data(), static_cast<std::size_t>(length)));
}

/// The name of "NAME=DIR".
Result<std::string> nameIn(const std::string& text) {
    const auto equals = text.find('=');
    auto name = text.substr(0, equals);
    if (equals == std::string::npos || equals + 1 == text.size() || !isRootName(name)) {
        return invalid(text, "a root is NAME=DIR, its name of letters, digits, '_' and '-'");
    }
    return name;
}

Result<Roots::Entry> parseEntry(const std::string& text) {
    MOTE_ASSIGN_OR_RETURN(auto name, nameIn(text));
    std::error_code code;
    auto folder = fs::canonical(text.substr(name.size() + 1), code);
    if (code) return systemError(code.value(), text, "the root's folder cannot be opened");
    if (!fs::is_directory(folder, code)) return invalid(text, "the root is not a folder");
    return Roots::Entry{std::move(name), std::move(folder)};
}

}  // namespace

Status Roots::check(const std::vector<std::string>& texts) {
    std::set<std::string> names;
    for (const auto& text : texts) {
        MOTE_ASSIGN_OR_RETURN(auto name, nameIn(text));
        if (!names.insert(std::move(name)).second) return invalid(text, "two roots have the same name");
    }
    return success();
}

Result<Roots> Roots::parse(const std::vector<std::string>& texts) {
    MOTE_RETURN_IF_ERROR(check(texts));
    Roots roots;
    for (const auto& text : texts) {
        MOTE_ASSIGN_OR_RETURN(auto entry, parseEntry(text));
        roots.entries_.push_back(std::move(entry));
    }
    return roots;
}

Result<fs::path> Roots::resolveExisting(std::string_view name) const {
    MOTE_ASSIGN_OR_RETURN(const auto place, locate(entries_, name));
    MOTE_ASSIGN_OR_RETURN(const auto opened, openBeneath(place, name, 0));
    return pathOf(opened, name);
}

Result<PathBeneath> Roots::beneath(std::string_view name) const {
    MOTE_ASSIGN_OR_RETURN(auto place, locate(entries_, name));
    return PathBeneath(place.root->folder, std::move(place.path));
}

Result<fs::path> Roots::resolveNew(std::string_view name) const {
    MOTE_ASSIGN_OR_RETURN(auto place, locate(entries_, name));
    if (place.path.empty()) return invalid(name, "names a root, not something beneath it");
    const fs::path path = place.path;
    place.path = path.parent_path().string();
    MOTE_ASSIGN_OR_RETURN(const auto parent, openBeneath(place, name, O_DIRECTORY));
    struct stat status {};
    // A dangling link counts as something that is there.
    if (::fstatat(parent.get(), path.filename().c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0) {
        return Error{ErrorCode::alreadyExists, std::string(name), "exists already"};
    }
    if (errno != ENOENT) return systemError(errno, std::string(name), "cannot be looked up");
    MOTE_ASSIGN_OR_RETURN(const auto folder, pathOf(parent, name));
    return folder / path.filename();
}

std::optional<std::string> Roots::nameOf(const fs::path& path) const {
    if (!path.is_absolute()) return std::nullopt;
    fs::path normal = path.lexically_normal();
    if (!normal.has_filename() && normal.has_relative_path()) normal = normal.parent_path();
    const Entry* best = nullptr;
    for (const auto& entry : entries_) {
        const auto [end, rest] =
            std::mismatch(entry.folder.begin(), entry.folder.end(), normal.begin(), normal.end());
        if (end != entry.folder.end()) continue;
        if (!best || entry.folder.native().size() > best->folder.native().size()) best = &entry;
    }
    if (!best) return std::nullopt;
    const auto relative = normal.lexically_relative(best->folder);
    return relative == "." ? best->name : best->name + "/" + relative.generic_string();
}

}  // namespace mote::storage
