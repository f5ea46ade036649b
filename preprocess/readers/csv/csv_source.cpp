// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/csv/csv_source.h"

#include <algorithm>
#include <array>
#include <limits>
#include <set>

#include "preprocess/readers/file_number.h"
#include "preprocess/readers/odd_steps.h"
#include "preprocess/readers/text/number.h"
#include "preprocess/readers/text/row_file.h"

namespace mote::prep {
namespace {

using Fields = std::array<std::string_view, 1024>;

class CsvSource : public ParticleSource {
  public:
    CsvSource(CsvOptions options, Progress& progress) : options_(std::move(options)), progress_(progress) {}
    Status addFile(const std::filesystem::path& path);

    std::string format() const override { return "csv"; }
    const std::vector<SourceStep>& steps() const override { return steps_; }
    bool has(Column column) const override;
    double mass() const override { return tables_.front().header.columns.mass(); }
    std::string species() const override { return tables_.front().header.columns.species(); }
    double particleCharge() const override { return tables_.front().header.columns.charge(); }
    std::string weightUnit() const override;
    Status read(std::size_t step, std::uint64_t begin, std::size_t count, const std::vector<Column>& wanted,
                ParticleChunk& chunk) override;

  private:
    struct Table {
        RowFile file;
        CsvHeader header;
    };

    Status readFirstRow(Table& table);
    Status readRow(Table& table, const std::vector<std::size_t>& used, std::optional<std::size_t> idField,
                   std::size_t row, ParticleChunk& chunk);
    Result<double> number(const Table& table, std::size_t field) const;
    void noteOnce(const std::string& sentence) {
        if (noted_.insert(sentence).second) progress_.note(sentence);
    }

    CsvOptions options_;
    Progress& progress_;
    std::set<std::string> noted_;
    std::vector<SourceStep> steps_;
    std::vector<Table> tables_;
    std::size_t open_ = 0;
    Fields fields_;
    std::vector<std::vector<double>> values_;  // by place in the used fields
};

Error wrong(const RowFile& file, const CsvHeader& header, std::size_t index, std::string_view text) {
    return {ErrorCode::corrupt,
            file.where() + ", column " + std::to_string(index + 1) + " (" + header.names[index] + ")",
            "'" + std::string(text.substr(0, 40)) + "' is not a number"};
}

Status CsvSource::addFile(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(auto header, readCsvHeader(path, options_));
    MOTE_ASSIGN_OR_RETURN(auto file, RowFile::open(path, header.rows, progress_));
    const auto number = fileNumber(path);
    Table table{std::move(file), std::move(header)};
    MOTE_RETURN_IF_ERROR(readFirstRow(table));
    const TableColumns& columns = table.header.columns;
    for (const std::string& note : columns.notes()) noteOnce(note);
    if (!tables_.empty() && tables_.front().header.columns.mass() != columns.mass())
        noteOnce("the files' masses differ: that of the first one is taken");
    steps_.push_back({path.filename().string(), number.value_or(static_cast<std::int64_t>(steps_.size())),
                      0.0, table.file.rows()});
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

std::string CsvSource::weightUnit() const {
    const std::string& unit = tables_.front().header.columns.weightUnit();
    const bool same = std::all_of(tables_.begin(), tables_.end(), [&](const Table& table) {
        return table.header.columns.weightUnit() == unit;
    });
    return same ? unit : "";
}

bool CsvSource::has(Column column) const {
    return std::all_of(tables_.begin(), tables_.end(),
                       [&](const Table& table) { return table.header.columns.has(column); });
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
    return wrong(table.file, table.header, field, text);
}

Status CsvSource::read(std::size_t step, std::uint64_t begin, std::size_t count,
                       const std::vector<Column>& wanted, ParticleChunk& chunk) {
    MOTE_RETURN_IF_ERROR(checkRange(steps_, step, begin, count));
    if (open_ != step) tables_[open_].file.close();
    open_ = step;
    Table& table = tables_[step];
    const TableColumns& columns = table.header.columns;
    MOTE_RETURN_IF_ERROR(table.file.seek(begin, progress_));
    chunk.begin = begin;
    chunk.size = count;
    std::optional<std::size_t> idField;
    for (const Column column : wanted) {
        if (column == Column::id) {
            idField = columns.idField();
            chunk.id.resize(count);
            for (std::size_t i = 0; i < count; ++i) chunk.id[i] = begin + i;
        } else if (!columns.has(column) && column != Column::weight) {
            return Error{ErrorCode::invalidArgument, steps_[step].file,
                         "has not all columns that were asked for"};
        }
    }
    const std::vector<std::size_t> used = columns.needed(wanted);
    values_.resize(used.size());
    for (auto& values : values_) values.resize(count);
    for (std::size_t row = 0; row < count; ++row)
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
        return Error{ErrorCode::corrupt, table.file.where(),
                     "has " + std::to_string(count) + " fields where the header names " +
                         std::to_string(table.header.names.size())};
    }
    for (std::size_t i = 0; i < used.size(); ++i) {
        MOTE_ASSIGN_OR_RETURN(values_[i][row], number(table, used[i]));
    }
    if (!idField) return success();
    const auto id = parseId(fields_[*idField]);
    if (!id) return wrong(table.file, table.header, *idField, fields_[*idField]);
    chunk.id[row] = *id;
    return success();
}

}  // namespace

Result<std::unique_ptr<ParticleSource>> openCsv(const std::vector<std::filesystem::path>& files,
                                                CsvOptions options, Progress& progress) {
    auto source = std::make_unique<CsvSource>(std::move(options), progress);
    OddSteps odd;
    for (const std::filesystem::path& file : inOrder(files)) {
        MOTE_RETURN_IF_ERROR(odd.add(source->addFile(file)));
    }
    MOTE_RETURN_IF_ERROR(odd.finish(!source->steps().empty(), progress));
    return std::unique_ptr<ParticleSource>(std::move(source));
}

}  // namespace mote::prep
