// SPDX-License-Identifier: GPL-3.0-or-later
//
// H5Numbers: a foreign dataset of numbers of any number of dimensions, read box by box. What the dataset
// declares (extent, chunks, filters, where its bytes lie) is checked against the file before anything is
// read. Owned by a reader; used from one thread at a time.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "preprocess/readers/adios2/bp_tree.h"
#include "preprocess/readers/hdf5/h5_chunks.h"
#include "preprocess/readers/hdf5/h5_file.h"
#include "protocol/base/error.h"

namespace mote::prep {

class H5Numbers {
  public:
    /// `dataset` is of `file`; a column has no more than one dimension that is longer than 1. Errors:
    /// unsupported (external or virtual storage, a filter other than deflate, lzf, shuffle and fletcher32, no
    /// numbers), corrupt (declares more than the file can hold).
    static Result<H5Numbers> open(const H5File& file, H5Object dataset, bool column = false);

    const H5Object& object() const { return dataset_; }
    /// Values along each dimension, the last one fastest; none of a single value.
    const std::vector<hsize_t>& extent() const { return extent_; }
    /// How a value is stored.
    std::size_t valueBytes() const { return valueBytes_; }
    bool isFloat() const { return float_; }
    bool isSigned() const { return signed_; }
    /// Whether they are stored as this machine's floats, so that reading them as such converts nothing.
    bool isNativeFloat() const { return nativeFloat_; }
    /// Where in the file all values lie, one behind another, as they are; none: they do not, or not all.
    const std::optional<std::uint64_t>& offset() const { return offset_; }
    /// How it is cut into chunks; null if it is not.
    const H5Chunks* chunks() const { return chunks_.get(); }
    /// HDF5's name for how a value is stored.
    hid_t type() const { return type_.get(); }

    /// The values from `first` on, `count` along each dimension, as numbers of a type of HDF5's own
    /// (H5T_NATIVE_DOUBLE). The box lies within the extent. Errors: corrupt.
    Status read(std::span<const hsize_t> first, std::span<const hsize_t> count, hid_t memoryType,
                void* values) const;

  private:
    Status readBp(std::span<const hsize_t> first, std::span<const hsize_t> count, hid_t memoryType,
                  void* values) const;
    Status convert(std::vector<std::uint8_t>& bytes, std::size_t count, hid_t memoryType, void* values) const;
    Status readPlain(std::span<const hsize_t> first, std::span<const hsize_t> count, hid_t memoryType,
                     void* values) const;
    Status readChunks(std::span<const hsize_t> first, std::span<const hsize_t> count, hid_t memoryType,
                      void* values) const;

    H5Object dataset_;
    H5Handle space_, type_;
    std::unique_ptr<H5Chunks> chunks_;  // of a chunked dataset
    mutable H5Chunk chunk_;             // that was read last
    std::unique_ptr<BpValues> bp_;      // of a folder of ADIOS2
    std::vector<hsize_t> extent_;
    std::size_t valueBytes_ = 0;  // in the file
    std::optional<std::uint64_t> offset_;
    bool float_ = false, signed_ = false, nativeFloat_ = false;
};

}  // namespace mote::prep
