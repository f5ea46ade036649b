// SPDX-License-Identifier: GPL-3.0-or-later
//
// The files of a dataset while it is read and made: regular files only, no links, no more bytes than
// expected; whole writes, syncs, the one rename by which an output appears, and scratch files. Functions
// without state, any thread.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "protocol/base/error.h"
#include "storage/files/file_descriptor.h"
#include "storage/files/path_beneath.h"

namespace mote::storage {

/// A file of pieces that a job puts aside while it does not know yet where they will lie, in the
/// folder of the dataset that it makes. Gone with its owner; if the process is killed, with the folder.
/// append() and read() may be called from any thread.
class ScratchFile {
  public:
    /// A new one, removed in the end. Errors: alreadyExists, permissionDenied, resourceExhausted.
    static Result<std::unique_ptr<ScratchFile>> create(const std::filesystem::path& path);
    /// Another process' own, to read. Errors: notFound, permissionDenied.
    static Result<std::unique_ptr<ScratchFile>> open(const std::filesystem::path& path);

    ScratchFile(const ScratchFile&) = delete;
    ScratchFile& operator=(const ScratchFile&) = delete;
    ~ScratchFile();

    /// Returns where the bytes lie. Errors: resourceExhausted (disk full), internal.
    Result<std::uint64_t> append(std::span<const std::byte> bytes);
    /// Errors: internal, also if the file ends.
    Status read(std::uint64_t at, std::span<std::byte> bytes) const;
    /// So that processes of other machines can read it. Errors: resourceExhausted, internal.
    Status sync() const;

  private:
    ScratchFile(std::filesystem::path path, FileDescriptor file, bool own)
        : path_(std::move(path)), file_(std::move(file)), own_(own) {}

    std::filesystem::path path_;
    FileDescriptor file_;
    bool own_;
    std::atomic<std::uint64_t> end_{0};
};

/// Whether it is the name of a file directly in a folder: no such name leads out of it.
bool isPlainName(const std::string& name);

/// Whether an open file is in memory alone (tmpfs).
bool isInMemory(int descriptor);

/// Brings the pages of a file in memory alone that are about to be written, if they are many. Who writes them
/// holds the file's lock, and would get each page from the system meanwhile; here several do so at once. For
/// one alone it is more work. Whether it goes well shows when they are written.
void bringPages(int descriptor, std::uint64_t offset, std::size_t size);

/// Opens it to be read. Errors: notFound, permissionDenied, corrupt (a link, folder or device in a file's
/// place, or a link in a folder's).
Result<FileDescriptor> openRegular(const PathBeneath& path);

/// The whole file. Errors: as openRegular, resourceExhausted (larger than `limit`), internal.
Result<std::string> readWhole(const PathBeneath& path, std::size_t limit);

/// Writes and syncs a file that must not exist yet. Errors: alreadyExists, permissionDenied, notFound (its
/// folder), resourceExhausted (disk full). The file is removed after an error.
Status writeNewFile(const std::filesystem::path& path, std::string_view text);

/// What the system's cache keeps of what is written or read: all of it, or no more than it had, where the
/// system can do that (Linux 6.14 and most file systems of its disks). Then gigabytes that nobody looks at
/// soon take no fresh page each, and drive nothing out that is looked at.
enum class PageCache { kept, passed };

/// All of `bytes` at `offset` of an open file called `name`. Errors: resourceExhausted (disk full), internal.
Status writeAt(int descriptor, std::uint64_t offset, std::span<const std::byte> bytes,
               const std::filesystem::path& name, PageCache cache = PageCache::kept);

/// Fills `bytes` from `offset` of an open file called `name`. Errors: internal, also if the file ends.
Status readAt(int descriptor, std::uint64_t offset, std::span<std::byte> bytes,
              const std::filesystem::path& name, PageCache cache = PageCache::kept);

/// Reads as many bytes as come at once, past the cache; what pread() returns.
std::ptrdiff_t readPast(int descriptor, std::uint64_t offset, std::span<std::byte> bytes);

/// Asks the kernel to put a file, or a folder's entries, on the disk. Errors: notFound, resourceExhausted,
/// internal.
Status syncPath(const std::filesystem::path& path);

/// Gives `from` the name `to`, which must not exist (nothing is ever replaced), and syncs the folder. Errors:
/// alreadyExists, permissionDenied, resourceExhausted, internal; `from` has its own name then.
Status publishByRename(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace mote::storage
