// SPDX-License-Identifier: GPL-3.0-or-later
//
// H5Column: a foreign dataset as one column of numbers, read piece by piece. What the dataset declares
// (extent, chunks, filters, where its bytes lie) is checked against the file before anything is read. Owned
// by a reader; used from one thread at a time.
#pragma once

#include <cstdint>
#include <memory>

#include "preprocess/readers/hdf5/h5_chunks.h"
#include "preprocess/readers/hdf5/h5_file.h"
#include "protocol/scene/error.h"

namespace mote::prep {

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
