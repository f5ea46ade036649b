// SPDX-License-Identifier: GPL-3.0-or-later
//
// H5Column: a foreign dataset as one column of numbers, read piece by piece. What the dataset declares
// (extent, chunks, filters, where its bytes lie) is checked against the file before anything is read. Owned
// by a reader; used from one thread at a time.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "preprocess/readers/hdf5/h5_file.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// The values of a dataset that is stored in chunks, decoded by our own code (deflate, shuffle,
/// fletcher32). HDF5's own reading (1.10) believes that a decoded chunk has the size of a chunk; a changed
/// filter mask is enough to make it read beyond one. The last chunk is kept, at most 1 GiB. Owned by a
/// column; one thread at a time.
class H5Chunks {
  public:
    /// Opens `dataset`, which is chunked and has values of `valueBytes`, along its dimension `axis`;
    /// `fileBytes` is the size of its file. Errors: corrupt, unsupported (another filter, chunks of more than
    /// 1 GiB).
    static Result<H5Chunks> open(const H5Object& dataset, int axis, std::size_t valueBytes,
                                 std::uint64_t fileBytes);

    /// How many bytes come out of one stored byte at most: 1 without deflate.
    std::uint64_t greatestRatio() const;

    /// Appends values [begin, begin + count), in the file's own type, to `bytes`. Errors, at `where`:
    /// corrupt.
    Status read(hid_t dataset, std::uint64_t begin, std::size_t count, std::vector<std::uint8_t>& bytes,
                const std::string& where);

  private:
    struct Filter {
        H5Z_filter_t id = 0;
        std::size_t elementBytes = 1;  // of shuffle
    };

    Status readShape(const H5Object& dataset, hid_t creation);
    Status readFilters(const H5Object& dataset, hid_t creation);
    void readFillValue(hid_t creation, hid_t type);
    Status load(hid_t dataset, std::uint64_t chunk, const std::string& where);
    Status decode(std::uint32_t skipped, const std::string& where);
    bool inflateChunk();
    void unshuffle(std::size_t elementBytes);
    bool checkFletcher();

    std::size_t axis_ = 0, valueBytes_ = 0;
    std::vector<hsize_t> shape_;
    std::uint64_t chunkRows_ = 0, chunkBytes_ = 0, stride_ = 1,
                  fileBytes_ = 0;  // stride: values from row to row
    std::vector<Filter> filters_;
    std::vector<std::uint8_t> fill_;  // one value, for chunks that were never written
    std::uint64_t loaded_ = static_cast<std::uint64_t>(-1);
    std::vector<std::uint8_t> chunk_, scratch_;
};

class H5Column {
  public:
    /// `dataset` is of `file`. Errors: unsupported (external or virtual storage, a filter other than
    /// deflate, shuffle and fletcher32, no numbers, more than one dimension longer than 1), corrupt (declares
    /// more than the file can hold).
    static Result<H5Column> open(const H5File& file, H5Object dataset);

    std::uint64_t rows() const { return rows_; }
    const H5Object& object() const { return dataset_; }

    /// Values [begin, begin + count), which must lie within the rows, as doubles. Error: corrupt.
    Status read(std::uint64_t begin, std::size_t count, double* values) const;
    /// The same as unsigned integers: negative ones wrap, so that any 64-bit id survives.
    Status read(std::uint64_t begin, std::size_t count, std::uint64_t* values) const;

  private:
    Status setExtent(const H5Object& dataset);
    Status readAs(hid_t memoryType, std::uint64_t begin, std::size_t count, void* values) const;

    Status readPlain(hid_t memoryType, std::uint64_t begin, std::size_t count, void* values) const;
    Status readChunks(hid_t memoryType, std::uint64_t begin, std::size_t count, void* values) const;

    H5Object dataset_;
    H5Handle space_, type_;
    std::unique_ptr<H5Chunks> chunks_;  // of a chunked dataset; keeps the last one
    std::size_t valueBytes_ = 0;        // in the file
    int rank_ = 0;
    int axis_ = 0;  // the one dimension that is longer than 1
    std::uint64_t rows_ = 0;
    bool signed_ = false;
};

}  // namespace mote::prep
