// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/csv/csv_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "preprocess/readers/csv/csv_header.h"
#include "preprocess/readers/file_number.h"
#include "preprocess/readers/text/number.h"
#include "preprocess/readers/text/row_file.h"

namespace mote::prep {
namespace {

using Fields = std::array<std::string_view, 1024>;

class CsvSource : public ParticleSource {
  public:
    CsvSource(double mass, Progress& progress) : mass_(mass), progress_(progress) {}
    Status addFile(const std::filesystem::path& path);

    std::string format() const override { return "csv"; }
    const std::vector<SourceStep>& steps() const override { return steps_; }
    bool has(Column column) const override;
    double mass() const override { return mass_; }
    Status read(std::size_t step, std::uint64_t begin, std::size_t count, const std::vector<Column>& wanted,
                ParticleChunk& chunk) override;

  private:
    struct Table {
        RowFile file;
        CsvHeader header;
    };

    Status readRow(Table& table, const std::vector<CsvHeader::Field>& used, std::size_t row,
                   ParticleChunk& chunk);

    double mass_;
    Progress& progress_;
    std::vector<SourceStep> steps_;
    std::vector<Table> tables_;
    std::size_t open_ = 0;
    Fields fields_;
};

Error wrong(const RowFile& file, const CsvHeader& header, std::size_t index, std::string_view text) {
    return {ErrorCode::corrupt,
            file.where() + ", column " + std::to_string(index + 1) + " (" + header.names[index] + ")",
            "'" + std::string(text.substr(0, 40)) + "' is not a number"};
}

Status CsvSource::addFile(const std::filesystem::path& path) {
    auto header = readCsvHeader(path, mass_);
    if (!header) return header.error();
    auto file = RowFile::open(path, header->rows, progress_);
    if (!file) return file.error();
    const auto number = fileNumber(path);
    steps_.push_back({path.filename().string(), number.value_or(static_cast<std::int64_t>(steps_.size())),
                      0.0, file->rows()});
    tables_.push_back({std::move(*file), std::move(*header)});
    return success();
}

bool CsvSource::has(Column column) const {
    return std::all_of(tables_.begin(), tables_.end(),
                       [&](const Table& table) { return table.header.find(column) != nullptr; });
}

Status CsvSource::read(std::size_t step, std::uint64_t begin, std::size_t count,
                       const std::vector<Column>& wanted, ParticleChunk& chunk) {
    MOTE_RETURN_IF_ERROR(checkRange(steps_, step, begin, count));
    if (open_ != step) tables_[open_].file.close();
    open_ = step;
    Table& table = tables_[step];
    MOTE_RETURN_IF_ERROR(table.file.seek(begin, progress_));
    chunk.begin = begin;
    chunk.size = count;
    chunk.lost.assign(count, 0);
    std::vector<CsvHeader::Field> used;
    for (const CsvHeader::Field& field : table.header.known) {
        const bool status = field.meaning.kind != FieldMeaning::Kind::column;
        if (status || std::find(wanted.begin(), wanted.end(), field.meaning.column) != wanted.end()) {
            used.push_back(field);
        }
    }
    for (const Column column : wanted) {
        const bool present = table.header.find(column) != nullptr;
        if (column == Column::id) {
            chunk.id.resize(count);
            for (std::size_t i = 0; i < count && !present; ++i) chunk.id[i] = begin + i;
        } else if (present || column == Column::weight) {
            chunk[column].assign(count, 1.0);
        } else {
            return Error{ErrorCode::invalidArgument, steps_[step].file,
                         "has not all columns that were asked for"};
        }
    }
    for (std::size_t row = 0; row < count; ++row) MOTE_RETURN_IF_ERROR(readRow(table, used, row, chunk));
    return success();
}

Status CsvSource::readRow(Table& table, const std::vector<CsvHeader::Field>& used, std::size_t row,
                          ParticleChunk& chunk) {
    const CsvHeader& header = table.header;
    const auto line = table.file.next();
    if (!line) return line.error();
    const std::size_t count = splitFields(*line, header.separator, fields_);
    if (count < header.fields) {
        return Error{ErrorCode::corrupt, table.file.where(),
                     "has " + std::to_string(count) + " fields where the header names " +
                         std::to_string(header.fields)};
    }
    for (const CsvHeader::Field& field : used) {
        const std::string_view text = fields_[field.index];
        if (field.meaning.kind == FieldMeaning::Kind::column && field.meaning.column == Column::id) {
            const auto id = parseId(text);
            if (!id) return wrong(table.file, header, field.index, text);
            chunk.id[row] = *id;
            continue;
        }
        auto value = header.separator == ';' ? parseNumberWithComma(text) : parseNumber(text);
        // Tables of statistics programs leave a field empty where there is no value.
        if (!value && text.empty()) value = std::numeric_limits<double>::quiet_NaN();
        if (!value) return wrong(table.file, header, field.index, text);
        if (field.meaning.kind != FieldMeaning::Kind::column) {
            chunk.lost[row] |= saysLost(field.meaning.kind, *value) ? 1 : 0;
        } else if (field.meaning.column == Column::weight) {
            chunk[Column::weight][row] = std::abs(*value * field.meaning.factor);
        } else {
            chunk[field.meaning.column][row] = *value * field.meaning.factor;
        }
    }
    return success();
}

}  // namespace

Result<std::unique_ptr<ParticleSource>> openCsv(const std::vector<std::filesystem::path>& files, double mass,
                                                Progress& progress) {
    auto source = std::make_unique<CsvSource>(mass, progress);
    for (const std::filesystem::path& file : inOrder(files)) MOTE_RETURN_IF_ERROR(source->addFile(file));
    return std::unique_ptr<ParticleSource>(std::move(source));
}

}  // namespace mote::prep
