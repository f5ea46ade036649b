// SPDX-License-Identifier: GPL-3.0-or-later
//
// StepFile: a step file while it is written, by any number of threads and processes. One of them makes it:
// HDF5 lays it out and writes what describes it. The arrays then go to their places without HDF5, by whoever
// has a part of them: a full disk is an errno and not a library in disorder, and no process needs another's
// HDF5. Move-only; write() may be called from any thread.
//
// Writes a whole step file, NAME.h5, and its digest, NAME.digest, from arrays in memory; who has them in
// pieces takes StepFile. The same content gives the same bytes. One call at a time in a process: HDF5 is not
// thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "storage/arrays/hash_pass.h"
#include "storage/arrays/hdf5_layout.h"
#include "storage/files/file_descriptor.h"
#include "storage/hash.h"
#include "storage/particles/step_layout.h"

namespace mote::storage {

class StepFile {
  public:
    using Place = ArrayPlace;
    using Places = std::array<Place, stepArrays.size()>;

    /// `path` must be new. The same arguments give the same bytes. One call at a time in a process: HDF5 is
    /// not thread-safe. Errors: resourceExhausted (disk full), permissionDenied, alreadyExists, internal; a
    /// part of the file may be left.
    static Result<StepFile> create(const std::filesystem::path& path, const StepShape& shape,
                                   const StepAttributes& attributes);
    /// A file that another process made. Errors: notFound, permissionDenied.
    static Result<StepFile> open(const std::filesystem::path& path, const Places& places);

    const Places& places() const { return places_; }

    /// From now on the rows of points, which fit 32 bits, are held in `rows`, too, one for each point: they
    /// are read there, and what is written of them to the file stays out of the system's cache. `rows`
    /// outlives this. What stands in it counts as written.
    void holdRows(std::span<std::uint32_t> rows);

    /// Says before hashAhead() that nobody reads rows of points soon: they stay out of the system's cache.
    void leaveRows() { rowsUnread_ = true; }

    /// Bytes of an array, from its byte `at` on; of rows of points, whole ones. Errors: resourceExhausted
    /// (disk full), internal.
    Status write(StepArray which, std::uint64_t at, std::span<const std::byte> bytes) const;

    /// The same of what was written, by whomever. Errors: internal.
    Status read(StepArray which, std::uint64_t at, std::span<std::byte> bytes) const;

    /// Starts to read back and hash, on a thread of its own and in the order of the file, what complete() is
    /// called of, for hashes(). `cancelled` is asked from it, too. This stays where it is from now on.
    void hashAhead(std::function<bool()> cancelled);
    /// All bytes of the array are written. Nothing without hashAhead().
    void complete(StepArray which) const;

    /// Asks the kernel to put what this process wrote on the disk. Errors: resourceExhausted, internal.
    Status sync() const;

    struct Hashes {
        std::vector<std::uint64_t> blocks;  ///< those of the digest, of all arrays in turn
        FileHash whole;
    };
    /// Of what was written, by whomever, read back once, on all threads of the calling arena. `cancelled` is
    /// asked from any of them, unless hashAhead() was given one. Called once. Errors: internal, cancelled.
    Result<Hashes> hashes(const std::function<bool()>& cancelled) const;

    /// `blocks` are all of them.
    proto::Digest digest(const StepShape& shape, std::span<const std::uint64_t> blocks) const;

  private:
    StepFile(std::filesystem::path path, FileDescriptor file, const Places& places)
        : path_(std::move(path)), file_(std::move(file)), places_(places) {}

    std::span<std::uint32_t> heldRows(std::uint64_t at, std::size_t bytes) const;
    void readHeld(std::uint64_t at, std::span<std::byte> bytes) const;
    HashPass::File forHashes() const;

    std::filesystem::path path_;
    FileDescriptor file_;
    Places places_;
    std::span<std::uint32_t> rows_;  ///< by point; empty: they are not held
    bool rowsUnread_ = false;
    std::unique_ptr<HashPass> pass_;  ///< since hashAhead(); it reads the file above
};

/// `directory`/`name`.h5 and .digest, both new. Errors: resourceExhausted (disk full), permissionDenied,
/// alreadyExists, internal; the directory may then hold parts of them.
Status writeStep(const std::filesystem::path& directory, const std::string& name, const StepContent& content);

/// "step-000012"
std::string stepName(std::uint32_t step);

}  // namespace mote::storage
