// SPDX-License-Identifier: GPL-3.0-or-later
//
// NpyArray: an array of a .npy file or of a .npz archive, its header checked against the bytes that there
// are; NpyReader: its numbers that lie at equal distances. An array is a value; a reader has one owner and is
// used by one thread at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "preprocess/readers/npy/array_bytes.h"
#include "preprocess/readers/npy/npy_header.h"
#include "protocol/base/error.h"

namespace mote::prep {

struct NpyArray {
    std::string name;  ///< in its archive, without ".npy"; "" in a .npy file
    ArrayBytes::Part part;
    NpyHeader header;

    /// Errors: those of ArrayBytes and NpyHeader::parse; corrupt (a header that contradicts the part's size).
    static Result<NpyArray> open(std::string name, ArrayBytes::Part part);
};

/// The arrays of a file: one of a .npy file, those of the entries NAME.npy of an archive. Errors: those of
/// NpyArray::open and readZipDirectory; unsupported (gzipped, an archive without arrays), notFound. An array
/// of an archive whose type is not read is left out.
Result<std::vector<NpyArray>> openNpyArrays(const std::filesystem::path& file);

/// Where numbers of an array lie: one a row, and so again for each step.
struct NpyNumbers {
    NpyField type;                 ///< count 1
    std::uint64_t offset = 0;      ///< bytes, of row 0 of step 0 in the array's part
    std::uint64_t stride = 0;      ///< bytes from row to row; 0: all rows have one number
    std::uint64_t stepStride = 0;  ///< bytes from step to step
};

class NpyReader {
  public:
    /// Errors: those of ArrayBytes::open.
    static Result<NpyReader> open(const NpyArray& array, NpyNumbers numbers);

    /// Numbers of rows [begin, begin + values.size()) of a step, which must lie within the array. `last`:
    /// nothing of the array comes behind them, so that its checksum is looked at. Errors: those of
    /// ArrayBytes::read.
    Status read(std::uint64_t step, std::uint64_t begin, bool last, std::span<double> values);
    Status read(std::uint64_t step, std::uint64_t begin, bool last, std::span<std::uint64_t> values);

  private:
    NpyReader(ArrayBytes bytes, NpyNumbers numbers)
        : bytes_(std::move(bytes)), numbers_(std::move(numbers)) {}
    template <class Value>
    Status readAs(std::uint64_t step, std::uint64_t begin, bool last, std::span<Value> values);

    ArrayBytes bytes_;
    NpyNumbers numbers_;
    std::vector<char> block_;
};

}  // namespace mote::prep
