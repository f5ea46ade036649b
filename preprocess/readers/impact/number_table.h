// SPDX-License-Identifier: GPL-3.0-or-later
//
// NumberTable: a text table of numbers without a header, as Fortran programs write them, with perhaps a first
// line that says how many rows follow. Owned by a reader; one thread at a time.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "preprocess/job.h"
#include "preprocess/readers/text/row_file.h"
#include "protocol/base/error.h"

namespace mote::prep {

class NumberTable {
  public:
    static constexpr std::size_t maxColumns = 16;

    /// What the first two rows say about a file.
    struct Shape {
        std::size_t columns = 0;                 ///< 0: an empty file
        std::optional<std::uint64_t> declared;   ///< rows, where the first line says so
        bool numbers = true;                     ///< every field of them is a number
        std::array<double, maxColumns> first{};  ///< row with so many columns, where all are numbers
    };
    /// Errors: those of LineReader.
    static Result<Shape> probe(const std::filesystem::path& path);

    /// Errors: corrupt (fewer than `columns` columns), those of RowFile.
    static Result<NumberTable> open(const std::filesystem::path& path, std::size_t columns,
                                    Progress& progress);

    std::uint64_t rows() const { return file_.rows(); }
    std::size_t columns() const { return shape_.columns; }  ///< of the first row
    const Shape& shape() const { return shape_; }
    Status seek(std::uint64_t row, Progress& progress) { return file_.seek(row, progress); }
    void close() { file_.close(); }
    std::string where() const { return file_.where(); }  ///< of the last row, for messages

    /// The next row: values of the columns whose bit is set in `needed`, the others untouched. Error:
    /// corrupt, with line and column.
    Status next(std::uint32_t needed, std::array<double, maxColumns>& values);

  private:
    explicit NumberTable(RowFile file) : file_(std::move(file)) {}

    RowFile file_;
    Shape shape_;
};

}  // namespace mote::prep
