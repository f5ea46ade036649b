// SPDX-License-Identifier: GPL-3.0-or-later
//
// MappedFile: a regular file's bytes, mapped read-only, unmapped when it goes. Move-only; the bytes may be
// read from any thread. Published files never change; of one that does while it is mapped, damage() tells
// (MappingGuard), so that nothing that was read of it is used.
#pragma once

#include <sys/stat.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "protocol/base/error.h"
#include "storage/files/file_descriptor.h"
#include "storage/files/path_beneath.h"

namespace mote::storage {

/// Once, by main, before the first mapping is read. SIGBUS at other addresses goes to the handler before
/// ours.
void catchMappingFaults();

/// A mapping of a file whose pages may vanish. Who touches a page beyond the end of a file that
/// was truncated meanwhile, or one that its disk cannot read, gets SIGBUS. In a process that called
/// catchMappingFaults(), such a page of a guarded mapping becomes zeros instead, with all after it, and the
/// guard knows: what was read since is worth nothing, and whoever reads asks fault() before it uses or shows
/// what it made.
///
/// A signal handler has no argument, so the guarded ranges stand in one table of the process, which the
/// handler reads without locks. Move-only; fault() on any thread.
class MappingGuard {
  public:
    static constexpr std::size_t most = 4096;  ///< guarded mappings of a process

    /// `bytes` is a whole mapping, from a page's begin, that outlives the guard; not empty. Errors:
    /// resourceExhausted.
    static Result<MappingGuard> make(std::span<const std::byte> bytes);

    MappingGuard() = default;
    MappingGuard(MappingGuard&& other) noexcept : slot_(std::exchange(other.slot_, none)) {}
    MappingGuard& operator=(MappingGuard&& other) noexcept {
        std::swap(slot_, other.slot_);
        return *this;
    }
    ~MappingGuard();

    /// The least offset, in bytes, of a page that was touched and could not be read; nothing as long as all
    /// is well.
    std::optional<std::uint64_t> fault() const;

  private:
    static constexpr std::size_t none = SIZE_MAX;

    explicit MappingGuard(std::size_t slot) : slot_(slot) {}

    std::size_t slot_ = none;
};

class MappedFile {
  public:
    /// Errors: as openRegular, corrupt (its size is not `expectedSize`), resourceExhausted.
    static Result<MappedFile> open(const PathBeneath& path, std::uint64_t expectedSize);

    /// What a packed file (packed_file.h) holds, in memory of its own, for which `most` bytes are taken at
    /// most. Errors: as openRegular, corrupt (it holds more), resourceExhausted.
    static Result<MappedFile> unpack(const PathBeneath& path, std::uint64_t most);

    MappedFile(MappedFile&& other) noexcept
        : path_(std::move(other.path_)),
          file_(std::move(other.file_)),
          bytes_(std::exchange(other.bytes_, {})),
          guard_(std::move(other.guard_)),
          written_(other.written_),
          changed_(other.changed_) {}
    MappedFile& operator=(MappedFile&&) = delete;
    ~MappedFile();

    const std::string& path() const { return path_; }
    std::span<const std::byte> bytes() const { return bytes_; }

    /// Whether a byte that was touched could not be read: what was read since may be zeros. Costs nothing.
    bool faulted() const { return guard_.fault().has_value(); }
    /// Why what was read up to now is worth nothing: a page that could not be read, or a file that was
    /// truncated or written to since it was opened. Asks the kernel once.
    std::optional<Error> damage() const;

    /// Asks for bytes [begin, begin + size) ahead of their use: returns at once.
    void expect(std::uint64_t begin, std::uint64_t size) const;
    /// Brings them in, as few page faults as the kernel knows how to.
    void populate(std::uint64_t begin, std::uint64_t size) const;
    /// Takes the whole pages among them from this process; they are read again at their next use.
    void giveUp(std::uint64_t begin, std::uint64_t size) const;

  private:
    MappedFile(std::string path, FileDescriptor file) : path_(std::move(path)), file_(std::move(file)) {}
    Status map(std::uint64_t size);
    void advise(std::uint64_t first, std::uint64_t last, int advice) const;

    std::string path_;
    FileDescriptor file_;
    std::span<const std::byte> bytes_;
    MappingGuard guard_;
    timespec written_{};  ///< last time of writing, when it was opened; anyone may put it back
    timespec changed_{};  ///< likewise, and of any other change; the kernel's own
};

}  // namespace mote::storage
