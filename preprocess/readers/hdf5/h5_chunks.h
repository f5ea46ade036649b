// SPDX-License-Identifier: GPL-3.0-or-later
//
// H5Chunks: the values of a dataset that is stored in chunks, decoded by our own code (deflate, lzf,
// shuffle, fletcher32). HDF5's own reading (1.10) believes that a decoded chunk has the size of a chunk; a
// changed filter mask is enough to make it read beyond one. Owned by whoever reads the dataset; several
// threads may decode at once where HDF5 itself may be called from several.
//
// H5Chunk: one of them, decoded, at most 1 GiB. A value, one thread at a time. H5ChunkStore: those that were
// decoded last, one for each thread that reads at once. Any thread.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "preprocess/readers/hdf5/h5_file.h"
#include "protocol/base/error.h"

namespace mote::prep {

struct H5Chunk {
    std::vector<hsize_t> first;  ///< where its first value stands; empty: nothing is decoded
    std::vector<std::uint8_t> bytes;
};

class H5ChunkStore {
  public:
    /// The chunk that begins at `first` if it is there, else any, or a new one. It is another's until it
    /// comes back.
    std::unique_ptr<H5Chunk> take(const std::vector<hsize_t>& first);
    void giveBack(std::unique_ptr<H5Chunk> chunk);

  private:
    std::mutex mutex_;
    std::vector<std::unique_ptr<H5Chunk>> chunks_;  ///< under it
};

class H5Chunks {
  public:
    /// Opens `dataset`, which is chunked and has values of `valueBytes`; `fileBytes` is the size of its file.
    /// Errors: corrupt, unsupported (another filter, chunks of more than 1 GiB).
    static Result<H5Chunks> open(const H5Object& dataset, std::size_t valueBytes, std::uint64_t fileBytes);

    /// Values of a chunk along each dimension.
    const std::vector<hsize_t>& shape() const { return shape_; }

    /// Of a chunk, decoded.
    std::uint64_t bytes() const { return chunkBytes_; }

    /// How many bytes come out of one stored byte at most: 1 where none is compressed.
    std::uint64_t greatestRatio() const;

    /// Decodes the chunk whose first value stands at `first` to `chunk`, unless it is there: all its values,
    /// in the file's own type. Errors, at `where`: corrupt.
    Status load(hid_t dataset, const std::vector<hsize_t>& first, const std::string& where,
                H5Chunk& chunk) const;

  private:
    struct Filter {
        H5Z_filter_t id = 0;
        std::size_t elementBytes = 1;  // of shuffle
    };

    Status readShape(const H5Object& dataset, hid_t creation);
    Status readFilters(const H5Object& dataset, hid_t creation);
    void readFillValue(hid_t creation, hid_t type);
    void fill(std::vector<std::uint8_t>& chunk) const;
    Status decode(std::uint32_t skipped, const std::string& where, std::vector<std::uint8_t>& chunk,
                  std::vector<std::uint8_t>& scratch) const;
    bool inflateChunk(std::vector<std::uint8_t>& chunk, std::vector<std::uint8_t>& scratch) const;

    std::size_t valueBytes_ = 0;
    std::vector<hsize_t> shape_;
    std::uint64_t chunkBytes_ = 0, fileBytes_ = 0;
    std::vector<Filter> filters_;
    std::vector<std::uint8_t> fill_;  // one value, for chunks that were never written
};

}  // namespace mote::prep
