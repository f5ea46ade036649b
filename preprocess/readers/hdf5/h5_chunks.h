// SPDX-License-Identifier: GPL-3.0-or-later
//
// H5Chunks: the values of a dataset that is stored in chunks, decoded by our own code (deflate, lzf,
// shuffle, fletcher32). HDF5's own reading (1.10) believes that a decoded chunk has the size of a chunk; a
// changed filter mask is enough to make it read beyond one. The last chunk is kept, at most 1 GiB. Owned by
// whoever reads the dataset; one thread at a time.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "preprocess/readers/hdf5/h5_file.h"
#include "protocol/scene/error.h"

namespace mote::prep {

class H5Chunks {
  public:
    /// Opens `dataset`, which is chunked and has values of `valueBytes`; `fileBytes` is the size of its file.
    /// Errors: corrupt, unsupported (another filter, chunks of more than 1 GiB).
    static Result<H5Chunks> open(const H5Object& dataset, std::size_t valueBytes, std::uint64_t fileBytes);

    /// Values of a chunk along each dimension.
    const std::vector<hsize_t>& shape() const { return shape_; }

    /// How many bytes come out of one stored byte at most: 1 where none is compressed.
    std::uint64_t greatestRatio() const;

    /// All values, in the file's own type, of the chunk whose first one stands at `first`: until the next
    /// call. Errors, at `where`: corrupt.
    Result<std::span<const std::uint8_t>> chunk(hid_t dataset, const std::vector<hsize_t>& first,
                                                const std::string& where);

  private:
    struct Filter {
        H5Z_filter_t id = 0;
        std::size_t elementBytes = 1;  // of shuffle
    };

    Status readShape(const H5Object& dataset, hid_t creation);
    Status readFilters(const H5Object& dataset, hid_t creation);
    void readFillValue(hid_t creation, hid_t type);
    Status load(hid_t dataset, const std::vector<hsize_t>& first, const std::string& where);
    Status decode(std::uint32_t skipped, const std::string& where);
    bool inflateChunk();
    void unshuffle(std::size_t elementBytes);
    bool checkFletcher();

    std::size_t valueBytes_ = 0;
    std::vector<hsize_t> shape_;
    std::uint64_t chunkBytes_ = 0, fileBytes_ = 0;
    std::vector<Filter> filters_;
    std::vector<std::uint8_t> fill_;  // one value, for chunks that were never written
    std::vector<hsize_t> loaded_;     // the first value of the chunk that is there; empty: none
    std::vector<std::uint8_t> chunk_, scratch_;
};

}  // namespace mote::prep
