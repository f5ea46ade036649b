// SPDX-License-Identifier: GPL-3.0-or-later
//
// H5Column: a foreign dataset as one column of numbers, read piece by piece. Owned by a reader; used from one
// thread at a time.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "preprocess/readers/hdf5/h5_file.h"
#include "preprocess/readers/hdf5/h5_numbers.h"
#include "protocol/scene/error.h"

namespace mote::prep {

class H5Column {
  public:
    /// `dataset` is of `file`. Errors: unsupported (external or virtual storage, a filter other than
    /// deflate, lzf, shuffle and fletcher32, no numbers, more than one dimension longer than 1), corrupt
    /// (declares more than the file can hold).
    static Result<H5Column> open(const H5File& file, H5Object dataset);

    std::uint64_t rows() const { return rows_; }
    const H5Object& object() const { return numbers_.object(); }

    /// Values [begin, begin + count), which must lie within the rows, as doubles. Error: corrupt.
    Status read(std::uint64_t begin, std::size_t count, double* values) const;
    /// The same as unsigned integers: negative ones wrap, so that any 64-bit id survives.
    Status read(std::uint64_t begin, std::size_t count, std::uint64_t* values) const;

  private:
    explicit H5Column(H5Numbers numbers) : numbers_(std::move(numbers)) {}
    Status readAs(hid_t memoryType, std::uint64_t begin, std::size_t count, void* values) const;

    H5Numbers numbers_;
    mutable std::vector<float> floats_;  // as they were read last
    std::size_t axis_ = 0;               // the one dimension that is longer than 1
    std::uint64_t rows_ = 1;
};

}  // namespace mote::prep
