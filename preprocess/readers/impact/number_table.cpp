// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/impact/number_table.h"

#include <algorithm>

#include "preprocess/readers/text/number.h"
#include "preprocess/readers/text/row_file.h"

namespace mote::prep {
namespace {

constexpr std::size_t fewestOfParticle = 6;  // of a particle; a first line with fewer counts the rows
constexpr std::uint64_t maxProbedLines = 10'000;

using Fields = std::array<std::string_view, NumberTable::maxColumns>;

/// Whether all fields are numbers; as far as they are, they become `values`.
bool takeNumbers(const Fields& fields, std::size_t count,
                 std::array<double, NumberTable::maxColumns>& values) {
    for (std::size_t i = 0; i < std::min(count, fields.size()); ++i) {
        const auto value = parseNumber(fields[i]);
        if (!value) return false;
        values[i] = *value;
    }
    return true;
}

}  // namespace

Result<NumberTable::Shape> NumberTable::probe(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(auto reader, LineReader::open(path));
    Shape shape;
    int rows = 0;
    for (std::string_view line; rows < 2 && reader.lineNumber() < maxProbedLines;) {
        MOTE_ASSIGN_OR_RETURN(const auto more, reader.next(line));
        if (!more) break;
        if (!isRow(line)) continue;
        Fields fields;
        const std::size_t count = splitFields(line, ' ', fields);
        std::array<double, maxColumns> values{};
        if (!takeNumbers(fields, count, values)) shape.numbers = false;
        if (rows == 1 && shape.columns < fewestOfParticle && count >= fewestOfParticle && shape.declared) {
            shape.columns = std::min(count, maxColumns);
            shape.first = values;
        } else if (rows == 0) {
            shape.columns = std::min(count, maxColumns);
            shape.first = values;
            if (count < fewestOfParticle) shape.declared = parseId(fields[0]);
        }
        ++rows;
    }
    if (shape.columns < fewestOfParticle && rows < 2 && shape.declared == 0u)
        shape.columns = fewestOfParticle;
    return shape;
}

Result<NumberTable> NumberTable::open(const std::filesystem::path& path, std::size_t columns,
                                      Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(const auto shape, probe(path));
    if (shape.columns != 0 && shape.columns < columns) {
        return corrupt(path.filename().string(), "has " + std::to_string(shape.columns) +
                                                     " columns where at least " + std::to_string(columns) +
                                                     " were expected");
    }
    MOTE_ASSIGN_OR_RETURN(auto file, RowFile::open(path, shape.declared ? 1 : 0, progress));
    NumberTable table(std::move(file));
    table.shape_ = shape;
    return table;
}

Status NumberTable::next(std::uint32_t needed, std::array<double, maxColumns>& values) {
    MOTE_ASSIGN_OR_RETURN(const auto line, file_.next());
    Fields fields;
    const std::size_t count = splitFields(line, ' ', fields);
    if (count < shape_.columns) {
        return corrupt(file_.where(), "has " + std::to_string(count) + " columns where the first row has " +
                                          std::to_string(shape_.columns));
    }
    for (std::size_t i = 0; i < shape_.columns; ++i) {
        if ((needed >> i & 1u) == 0) continue;
        const auto value = parseNumber(fields[i]);
        if (!value) {
            return noNumber(fields[i], file_.where(), std::to_string(i + 1));
        }
        values[i] = *value;
    }
    return success();
}

}  // namespace mote::prep
