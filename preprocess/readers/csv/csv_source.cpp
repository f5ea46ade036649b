// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/readers/particle_reader.h"
#include "preprocess/readers/table/table_columns.h"
#include "preprocess/readers/table/table_map.h"
#include "preprocess/readers/table/table_source.h"
#include "preprocess/readers/text/number.h"
#include "preprocess/readers/text/row_file.h"
#include "protocol/base/error.h"
#include "protocol/base/utf8.h"

namespace mote::prep {
namespace {

/// The line of names of a table in text; comma, semicolon, tab or blanks between the fields.
/// What a user says of a table.
struct CsvOptions {
    double mass = 0.0;  ///< eV/c^2, 0: as the table says
    TableMap map;
};

/// The lines of a table that name its columns. Values and functions without state.
struct CsvHeader {
    char separator = ',';            ///< ' ': runs of blanks
    std::vector<std::string> names;  ///< of the fields of a row, with their units
    std::uint64_t rows = 0;          ///< lines over the table that are no comments
    std::string where;               ///< of the names, for messages

    TableColumns columns;
};

constexpr std::size_t csvMaxFields = 1024;
constexpr std::uint64_t maxHeaderLines = 10'000;
constexpr std::uint64_t maxTitleLines = 64;  // that are no comments

using CsvFields = std::array<std::string_view, csvMaxFields>;

char separatorOf(std::string_view header) {
    for (const char separator : {';', '\t', ','}) {
        if (header.find(separator) != std::string_view::npos) return separator;
    }
    return ' ';
}

std::string_view withoutMark(std::string_view line) {
    if (line.starts_with("\xef\xbb\xbf")) line.remove_prefix(3);  // the byte order mark of UTF-8
    line = trim(line);
    while (!line.empty() && (line.front() == '#' || line.front() == '!' || line.front() == '%')) {
        line = trim(line.substr(1));
    }
    return line;
}

/// The names of a line; none where it has too many. Where blanks separate them, a unit in brackets belongs to
/// the name before it.
std::vector<std::string> namesOf(std::string_view line, char separator) {
    CsvFields fields;
    const std::size_t count = splitFields(line, separator, fields);
    std::vector<std::string> names;
    if (count > csvMaxFields) return names;
    bool inUnit = false;
    for (std::size_t i = 0; i < count; ++i) {
        const std::string_view field = fields[i];
        const bool opens = field.starts_with('[') || field.starts_with('(');
        if (separator == ' ' && !names.empty() && (inUnit || opens)) {
            names.back() += " " + std::string(field);
        } else {
            names.emplace_back(field);
        }
        const std::size_t open = names.back().find_first_of("[(");
        inUnit = open != std::string::npos && names.back().find_first_of("])", open) == std::string::npos;
    }
    if (names.size() > 1 && names.back().empty()) names.pop_back();  // a separator at the line's end
    return names;
}

/// A line of names, with what stands before it.
struct Candidate {
    std::vector<std::string> names;
    char separator = ',';
    std::uint64_t rows = 0;  // that are no comments, itself included
    std::string where;
    bool comment = false;
};

bool anyNumber(const std::vector<std::string>& names) {
    return std::any_of(names.begin(), names.end(),
                       [](const std::string& name) { return parseNumber(name).has_value(); });
}

/// Whether a line can name columns: a known name, no number.
bool namesColumns(const std::vector<std::string>& names) {
    return !anyNumber(names) && std::any_of(names.begin(), names.end(), [](const std::string& name) {
        const auto meaning = tableMeaning(name, "");
        return !meaning || meaning->has_value();
    });
}

/// Whether a row has as many fields as a line of names, and numbers among them. What stands in a comment may
/// be prose, and so may what a map of numbers fits: these must fit `exactly`, to the field.
bool isDataOf(const Candidate& candidate, std::string_view row, bool exactly) {
    CsvFields fields;
    const std::size_t count = splitFields(row, candidate.separator, fields);
    if (count < candidate.names.size() || count > csvMaxFields) return false;
    const bool ends = count == candidate.names.size() + 1 && fields[count - 1].empty();
    if (exactly && count != candidate.names.size() && !ends) return false;
    return std::any_of(
        fields.begin(), fields.begin() + static_cast<std::ptrdiff_t>(candidate.names.size()),
        [](std::string_view field) { return parseNumber(field) || parseNumberWithComma(field); });
}

/// Takes a line of units below the names: "[m] [eV/c]", "mm,MeV/c". Names that have a unit keep it.
bool takeUnits(Candidate& candidate, std::string_view line) {
    CsvFields fields;
    const std::size_t count = splitFields(withoutMark(line), candidate.separator, fields);
    if (count != candidate.names.size()) return false;
    const auto end = fields.begin() + static_cast<std::ptrdiff_t>(count);
    if (!std::all_of(fields.begin(), end, isTableUnit)) return false;
    // A row of ones would be units, too.
    const auto word = [](std::string_view field) {
        return !parseNumber(field) && !field.empty() && field != "-";
    };
    if (std::none_of(fields.begin(), end, word)) return false;
    for (std::size_t i = 0; i < count; ++i) {
        std::string_view unit = trim(fields[i]);
        if (unit.size() >= 2 && std::string_view("[({").find(unit.front()) != std::string_view::npos)
            unit = trim(unit.substr(1, unit.size() - 2));
        const bool none = unit.empty() || unit == "-";
        if (!none && candidate.names[i].find_first_of("[({") == std::string::npos)
            candidate.names[i] += " [" + std::string(unit) + "]";
    }
    return true;
}

/// What was found over the numbers.
struct Search {
    std::optional<Candidate> header;
    std::optional<Candidate> firstRow;  // for its error, where there is no header
    std::optional<Candidate> nameless;  // numbers from the first row on
};

class HeaderFinder {
  public:
    explicit HeaderFinder(const TableMap& map) : map_(map) {}

    Result<Search> find(LineReader& reader) {
        for (std::string_view line; reader.lineNumber() < maxHeaderLines;) {
            MOTE_ASSIGN_OR_RETURN(const auto more, reader.next(line));
            if (!more) break;
            const bool row = isRow(withoutByteOrder(line));
            if (row) ++rows_;
            if (look(line, row, reader.name() + ": line " + std::to_string(reader.lineNumber()))) break;
            if (rows_ > maxTitleLines) break;
        }
        return std::move(search_);
    }

  private:
    static std::string_view withoutByteOrder(std::string_view line) {
        if (line.starts_with("\xef\xbb\xbf")) line.remove_prefix(3);
        return line;
    }

    /// True once the numbers begin.
    bool look(std::string_view line, bool row, std::string where) {
        if (search_.header && takeUnits(*search_.header, line)) {
            if (row) ++search_.header->rows;
            return false;
        }
        const bool exactly = search_.header && (search_.header->comment || !map_.empty());
        if (row && search_.header && isDataOf(*search_.header, line, exactly)) return true;
        const std::string_view plain = withoutMark(line);
        Candidate candidate;
        candidate.separator = separatorOf(plain);
        candidate.names = namesOf(plain, candidate.separator);
        candidate.rows = rows_;
        candidate.where = std::move(where);
        candidate.comment = !row;
        const bool fits = map_.empty() ? namesColumns(candidate.names)
                                       : !anyNumber(candidate.names) && !candidate.names.empty() &&
                                             map_.fits(candidate.names);
        // Words of a title may be names; the line of names has the more of them, and stands lower.
        if (fits) {
            if (row && !search_.firstRow) search_.firstRow = candidate;
            search_.header = std::move(candidate);
            return false;
        }
        if (!row) return false;
        const bool numbers = std::all_of(candidate.names.begin(), candidate.names.end(),
                                         [](const std::string& name) { return parseNumber(name); });
        if (!search_.firstRow) search_.firstRow = candidate;
        if (!numbers || candidate.names.empty()) return false;
        if (exactly) search_.header.reset();
        // One row of numbers may belong to the title, as in TraceWin's text or where it counts the rows; two
        // alike do not.
        if (search_.nameless && search_.nameless->names.size() == candidate.names.size()) return true;
        candidate.rows = rows_ - 1;
        search_.nameless = std::move(candidate);
        return false;
    }

    const TableMap& map_;
    Search search_;
    std::uint64_t rows_ = 0;
};

/// TraceWin's text has phases and an energy, which is the kinetic one; in other tables an energy may be any.
void nameKineticEnergy(std::vector<std::string>& names) {
    const auto like = [](std::string_view word) {
        return [word](const std::string& name) { return lower(name).starts_with(word); };
    };
    if (std::none_of(names.begin(), names.end(), like("phase"))) return;
    const auto energy = std::find_if(names.begin(), names.end(), like("energy"));
    if (energy != names.end()) *energy = "ekin" + energy->substr(std::string_view("energy").size());
}

Result<CsvHeader> headerOf(Candidate candidate, const CsvOptions& options) {
    CsvHeader header;
    header.separator = candidate.separator;
    header.names = std::move(candidate.names);
    header.rows = candidate.rows;
    header.where = std::move(candidate.where);
    std::vector<TableField> fields;
    std::vector<TableConstant> constants;
    if (options.map.empty()) {
        nameKineticEnergy(header.names);
        for (std::size_t i = 0; i < header.names.size(); ++i) fields.push_back({i, header.names[i]});
    } else {
        MOTE_RETURN_IF_ERROR(options.map.apply(header.names, fields, constants));
    }
    MOTE_ASSIGN_OR_RETURN(header.columns, TableColumns::of(fields, constants, options.mass, header.where));
    header.columns.addRecords(header.names);
    return header;
}

/// The header of a file: the last line over the numbers that names columns, in a comment or not, perhaps with
/// a line of units below it. With a map, the line that has the map's names, or none where it has numbers.
/// Errors: those of TableColumns::of, TableMap::apply and LineReader; notFound (no such line).
Result<CsvHeader> readCsvHeader(const std::filesystem::path& path, const CsvOptions& options) {
    MOTE_ASSIGN_OR_RETURN(auto reader, LineReader::open(path));
    MOTE_ASSIGN_OR_RETURN(auto search, HeaderFinder(options.map).find(reader));
    if (search.nameless && !options.map.empty() && !search.header) {
        for (std::size_t i = 0; i < search.nameless->names.size(); ++i)
            search.nameless->names[i] = "column " + std::to_string(i + 1);
        return headerOf(std::move(*search.nameless), options);
    }
    if (search.header) return headerOf(std::move(*search.header), options);
    if (search.firstRow) return headerOf(std::move(*search.firstRow), options);
    return notFound(reader.name(), "has no line with the columns' names");
}

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
    std::vector<std::size_t> used = columns.needed(wanted);
    for (const Column column : wanted) {
        if (isRecord(column)) used.push_back(recordField(step, column));
    }
    values_.resize(used.size());
    for (auto& values : values_) values.resize(chunk.size);
    for (std::size_t row = 0; row < chunk.size; ++row)
        MOTE_RETURN_IF_ERROR(readRow(table, used, idField, row, chunk));
    TableColumns::Values values(table.header.names.size(), nullptr);
    for (std::size_t i = 0; i < used.size(); ++i) values[used[i]] = values_[i].data();
    columns.fill(wanted, values, chunk);
    for (const Column column : wanted) {
        if (isRecord(column))
            std::copy_n(values[recordField(step, column)], chunk.size, chunk[column].data());
    }
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
