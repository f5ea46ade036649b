// SPDX-License-Identifier: GPL-3.0-or-later
//
// HashPass: reads a file of arrays back once, after it was written, for the hashes of its arrays' blocks and
// of the whole file, which is in the order of its bytes. Arrays that are complete may be read while others
// are written: then the disk is waited for meanwhile, and little is left for the end. One owner, who calls
// all of it; neither copied nor moved.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include "protocol/base/error.h"
#include "storage/arrays/hdf5_layout.h"
#include "storage/files/dataset_file.h"
#include "storage/hash.h"

namespace mote::storage {

class HashPass {
  public:
    /// Fills `bytes` with those of an array from its byte `at` on, where its owner has them; false: they are
    /// read from the file. Called from any thread, for arrays that are complete.
    using Held = std::function<bool(std::size_t array, std::uint64_t at, std::span<std::byte> bytes)>;

    /// An open file, of its whole size already, which stays open while the pass lives.
    struct File {
        int descriptor = -1;
        std::filesystem::path path;
        std::vector<ArrayPlace> places;
        std::vector<PageCache> cache;  ///< by array; what lies between them is kept
        Held held = {};                ///< may be empty
    };

    /// `cancelled` may be empty; it is asked from any thread, between pieces of some MiB.
    HashPass(File file, std::function<bool()> cancelled);
    ~HashPass();
    HashPass(const HashPass&) = delete;
    HashPass& operator=(const HashPass&) = delete;

    /// Starts a thread that reads each array once complete() was called of it, in the order of the file.
    void begin();
    /// All bytes of the array, by its index in File::places, are written.
    void complete(std::size_t array);

    /// Reads what is left, on all threads of the calling arena; all arrays are complete by now. Called once.
    /// Errors: internal, cancelled.
    Result<FileHash> finish();

    /// After finish(): hashes of an array's blocks.
    const std::vector<std::uint64_t>& blocks(std::size_t array) const { return blocks_[array]; }

  private:
    /// Some whole blocks of an array, or what lies between arrays.
    struct Piece {
        std::uint64_t offset, bytes;
        std::optional<std::size_t> array;
        std::size_t firstBlock;
    };

    Status cut();
    void cut(std::uint64_t begin, std::uint64_t end, std::optional<std::size_t> array);
    void hashAhead();
    void end();
    bool isCancelled() const { return cancelled_ && cancelled_(); }
    Error wasCancelled() const;
    Status read(const Piece& piece, std::span<std::byte> bytes) const;
    Status hashBlocks(const Piece& piece, std::vector<std::byte>& bytes);

    const File file_;
    const std::function<bool()> cancelled_;
    std::vector<Piece> pieces_;
    std::vector<std::vector<std::uint64_t>> blocks_;  ///< by array

    // Of the thread while there is one, then of finish().
    FileHasher whole_;
    std::size_t next_ = 0;  ///< piece
    Status status_ = success();

    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<bool> complete_;  ///< by array, under the mutex
    bool ending_ = false;         ///< under it
    std::thread thread_;
};

}  // namespace mote::storage
