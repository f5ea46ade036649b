// SPDX-License-Identifier: GPL-3.0-or-later
//
// Arrays as NumPy files (.npy, NEP 1), little-endian, in C order. Pure functions, and NpyRows, a file that
// grows by rows; one owner, one thread.
#pragma once

#include <bit>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "client/shared/part_file.h"
#include "protocol/base/error.h"

namespace mote::client {

/// A field of the rows of a structured array.
struct NpyField {
    std::string name;
    std::string type;        ///< of 8 bytes: "<f8", "<i8" or "<u8"
    std::string title = {};  ///< "x [m]", by which NumPy knows the field too; "": none
};

/// What a file of an array of f64 begins with; the values follow.
std::string npyHead(const std::vector<std::size_t>& shape);

/// The bytes of values, as files have them.
template <class T>
std::span<const std::uint8_t> bytesOf(std::span<const T> values) {
    static_assert(std::endian::native == std::endian::little);
    return {reinterpret_cast<const std::uint8_t*>(values.data()), values.size_bytes()};
}

class NpyRows {
  public:
    /// Errors: PartFile's, and resourceExhausted where there are too many fields for the format's head.
    static Result<NpyRows> create(const std::filesystem::path& path, const std::vector<NpyField>& fields);

    /// Rows of 8 bytes a field, one after the other. Errors: those of the system.
    Status append(std::span<const std::uint64_t> words);
    /// Says in the head how many rows there are; the file appears.
    Status publish();

  private:
    NpyRows(std::unique_ptr<PartFile> file, std::vector<NpyField> fields)
        : file_(std::move(file)), fields_(std::move(fields)) {}

    std::unique_ptr<PartFile> file_;
    std::vector<NpyField> fields_;
    std::uint64_t words_ = 0;
};

}  // namespace mote::client
