// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/csv/csv_header.h"

#include <algorithm>
#include <array>
#include <limits>

#include "preprocess/readers/particle_reader.h"
#include "preprocess/readers/table/table_source.h"
#include "preprocess/readers/text/number.h"
#include "preprocess/readers/text/row_file.h"

namespace mote::prep {
namespace {

using Fields = std::array<std::string_view, 1024>;

class CsvSource : public TableSource {
  public:
    CsvSource(CsvOptions options, Progress& progress)
        : TableSource("csv", progress), options_(std::move(options)) {}

  protected:
    Status addFile(const std::filesystem::path& path) override;
    Status readRows(std::size_t step, const std::vector<Column>& wanted, ParticleChunk& chunk) override;

  private:
    struct Table {
        RowFile file;
        CsvHeader header;
    };

    Status readFirstRow(Table& table);
    Status readRow(Table& table, const std::vector<std::size_t>& used, std::optional<std::size_t> idField,
                   std::size_t row, ParticleChunk& chunk);
    Result<double> number(const Table& table, std::size_t field) const;

    CsvOptions options_;
    std::vector<Table> tables_;
    std::size_t open_ = 0;
    Fields fields_;
    std::vector<std::vector<double>> values_;  // by place in the used fields
};

Error noCsvNumber(const RowFile& file, const CsvHeader& header, std::size_t index, std::string_view text) {
    return noNumber(text, file.where(), std::to_string(index + 1) + " (" + header.names[index] + ")");
}

Status CsvSource::addFile(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(auto header, readCsvHeader(path, options_));
    MOTE_ASSIGN_OR_RETURN(auto file, RowFile::open(path, header.rows, progress_));
    Table table{std::move(file), std::move(header)};
    MOTE_RETURN_IF_ERROR(readFirstRow(table));
    const TableColumns& columns = table.header.columns;
    for (const std::string& note : columns.notes()) noteOnce(note);
    if (!columns_.empty() && columns_.front().mass() != columns.mass())
        noteOnce("the files' masses differ: that of the first one is taken");
    steps_.push_back(stepOf(path, table.file.rows()));
    columns_.push_back(columns);
    tables_.push_back(std::move(table));
    return success();
}

/// Mass and charge of the first row are those of all: momenta are found with them.
Status CsvSource::readFirstRow(Table& table) {
    TableColumns& columns = table.header.columns;
    const auto massField = columns.massField(), chargeField = columns.chargeField();
    if (table.file.rows() == 0 || (!massField && !chargeField)) return success();
    MOTE_RETURN_IF_ERROR(table.file.seek(0, progress_));
    MOTE_ASSIGN_OR_RETURN(const auto line, table.file.next());
    if (splitFields(line, table.header.separator, fields_) >= table.header.names.size()) {
        if (massField) {
            MOTE_ASSIGN_OR_RETURN(const auto mass, number(table, *massField));
            columns.setMass(mass);
            noteOnce("the mass is that of the table's first row");
        }
        if (chargeField) {
            MOTE_ASSIGN_OR_RETURN(const auto charge, number(table, *chargeField));
            columns.setCharge(charge);
        }
    }
    table.file.close();
    return success();
}

Result<double> CsvSource::number(const Table& table, std::size_t field) const {
    const std::string_view text = fields_[field];
    const auto value = table.header.separator == ';' ? parseNumberWithComma(text) : parseNumber(text);
    if (value) return *value;
    // Tables of statistics programs leave a field empty where there is no value.
    if (text.empty()) return std::numeric_limits<double>::quiet_NaN();
    // Truth values as Python and R write them.
    if (text == "True" || text == "TRUE" || text == "true") return 1.0;
    if (text == "False" || text == "FALSE" || text == "false") return 0.0;
    return noCsvNumber(table.file, table.header, field, text);
}

Status CsvSource::readRows(std::size_t step, const std::vector<Column>& wanted, ParticleChunk& chunk) {
    if (open_ != step) tables_[open_].file.close();
    open_ = step;
    Table& table = tables_[step];
    const TableColumns& columns = columns_[step];
    MOTE_RETURN_IF_ERROR(table.file.seek(chunk.begin, progress_));
    const bool ids = std::find(wanted.begin(), wanted.end(), Column::id) != wanted.end();
    const auto idField = ids ? columns.idField() : std::nullopt;
    const std::vector<std::size_t> used = columns.needed(wanted);
    values_.resize(used.size());
    for (auto& values : values_) values.resize(chunk.size);
    for (std::size_t row = 0; row < chunk.size; ++row)
        MOTE_RETURN_IF_ERROR(readRow(table, used, idField, row, chunk));
    TableColumns::Values values(table.header.names.size(), nullptr);
    for (std::size_t i = 0; i < used.size(); ++i) values[used[i]] = values_[i].data();
    columns.fill(wanted, values, chunk);
    return success();
}

Status CsvSource::readRow(Table& table, const std::vector<std::size_t>& used,
                          std::optional<std::size_t> idField, std::size_t row, ParticleChunk& chunk) {
    MOTE_ASSIGN_OR_RETURN(const auto line, table.file.next());
    const std::size_t count = splitFields(line, table.header.separator, fields_);
    if (count < table.header.names.size()) {
        return corrupt(table.file.where(), "has " + std::to_string(count) +
                                               " fields where the header names " +
                                               std::to_string(table.header.names.size()));
    }
    for (std::size_t i = 0; i < used.size(); ++i) {
        MOTE_ASSIGN_OR_RETURN(values_[i][row], number(table, used[i]));
    }
    if (!idField) return success();
    const auto id = parseId(fields_[*idField]);
    if (!id) return noCsvNumber(table.file, table.header, *idField, fields_[*idField]);
    chunk.id[row] = *id;
    return success();
}

/// A unit or a name that is wrong in a line of names says more than that no format is known.
Result<bool> tellsCsv(const AskedFile& file) {
    const auto header = readCsvHeader(file.path, {massOf(file.job), {}});
    if (header) return true;
    return header.error().code == ErrorCode::notFound ? Result<bool>(false) : header.error();
}

Result<std::unique_ptr<ParticleSource>> openCsv(const AskedRun& run, Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(auto map, TableMap::parse(run.job.map()));
    return openSeries(std::make_unique<CsvSource>(CsvOptions{run.mass, std::move(map)}, progress),
                      inOrder(run.files));
}

}  // namespace

extern const ParticleReader csvReader;
constinit const ParticleReader csvReader{"csv", "a table with a line of names, or --map",
                                         ParticleReader::Kind::rows, tellsCsv, openCsv};

}  // namespace mote::prep
