// SPDX-License-Identifier: GPL-3.0-or-later
//
// NpyTable: the array of a .npy file as a table of rows, read piece by piece. Owned by a reader; one thread
// at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/npy/npy_header.h"
#include "preprocess/readers/text/byte_source.h"
#include "protocol/scene/error.h"

namespace mote::prep {

class NpyTable {
  public:
    /// One number of a row that means something to us.
    struct Field {
        FieldMeaning meaning;
        NpyField type;             ///< count 1
        std::uint64_t offset = 0;  ///< bytes, of row 0 in the file
        std::uint64_t stride = 0;  ///< bytes, from row to row
    };

    /// Checks the header against the file's size. `mass` in eV/c^2, 0: unknown. Errors: those of
    /// ByteSource::open and NpyHeader::parse; corrupt (a size that contradicts the file), unsupported
    /// (compressed, another shape).
    static Result<NpyTable> open(const std::filesystem::path& path, double mass);

    std::uint64_t rows() const { return rows_; }
    bool structured() const { return structured_; }
    const std::vector<Field>& fields() const { return fields_; }
    const Field* find(Column column) const;

    /// Values of rows [begin, begin + values.size()). Errors: corrupt, internal.
    Status read(const Field& field, std::uint64_t begin, std::span<double> values) const;
    Status read(const Field& field, std::uint64_t begin, std::span<std::uint64_t> values) const;

  private:
    Status setPlainFields(const NpyHeader& header);
    Status setNamedFields(const NpyHeader& header, double mass);
    template <class Value>
    Status readAs(const Field& field, std::uint64_t begin, std::span<Value> values) const;

    std::filesystem::path path_;
    std::string name_;
    std::uint64_t rows_ = 0;
    bool structured_ = false;
    std::vector<Field> fields_;
};

}  // namespace mote::prep
