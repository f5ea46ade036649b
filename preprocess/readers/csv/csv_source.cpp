// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/csv/csv_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "preprocess/readers/file_number.h"
#include "preprocess/readers/text/number.h"
#include "preprocess/readers/text/row_file.h"

namespace mote::prep {
namespace {

constexpr std::size_t maxFields = 1024;
constexpr std::uint64_t maxCommentLines = 10'000;

char separatorOf(std::string_view header) {
    for (const char separator : {';', '\t', ','}) {
        if (header.find(separator) != std::string_view::npos) return separator;
    }
    return ' ';
}

/// The names of a header. Where blanks separate them, a unit in brackets belongs to the name before it.
Result<std::vector<std::string>> namesOf(std::string_view line, char separator, const std::string& where) {
    std::array<std::string_view, maxFields> fields;
    const std::size_t count = splitFields(line, separator, fields);
    if (count > maxFields) return Error{ErrorCode::notFound, where, "has more than 1024 columns"};
    std::vector<std::string> names;
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

std::string_view withoutMark(std::string_view line) {
    if (line.starts_with("\xef\xbb\xbf")) line.remove_prefix(3);  // the byte order mark of UTF-8
    line = trim(line);
    while (!line.empty() && (line.front() == '#' || line.front() == '!' || line.front() == '%')) {
        line = trim(line.substr(1));
    }
    return line;
}

Result<CsvHeader> commentHeader(std::string_view comment, double mass, const std::string& where) {
    auto header = parseCsvHeader(comment, mass, where);
    if (header) header->rows = 0;
    return header;
}

/// Whether the names in a comment are those of the columns of `row`, which holds numbers.
bool fits(std::string_view comment, std::string_view row) {
    const auto header = parseCsvHeader(comment, 1.0, "");
    std::array<std::string_view, maxFields> fields;
    return header && splitFields(row, header->separator, fields) == header->fields && parseNumber(fields[0]);
}

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
    MOTE_ASSIGN_OR_RETURN(auto header, readCsvHeader(path, mass_));
    MOTE_ASSIGN_OR_RETURN(auto file, RowFile::open(path, header.rows, progress_));
    const auto number = fileNumber(path);
    steps_.push_back({path.filename().string(), number.value_or(static_cast<std::int64_t>(steps_.size())),
                      0.0, file.rows()});
    tables_.push_back({std::move(file), std::move(header)});
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
    MOTE_ASSIGN_OR_RETURN(const auto line, table.file.next());
    const std::size_t count = splitFields(line, header.separator, fields_);
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

const CsvHeader::Field* CsvHeader::find(Column column) const {
    for (const Field& field : known) {
        if (field.meaning.kind == FieldMeaning::Kind::column && field.meaning.column == column) return &field;
    }
    return nullptr;
}

Result<CsvHeader> parseCsvHeader(std::string_view line, double mass, const std::string& where) {
    line = withoutMark(line);
    CsvHeader header;
    header.separator = separatorOf(line);
    MOTE_ASSIGN_OR_RETURN(auto names, namesOf(line, header.separator, where));
    header.names = std::move(names);
    header.fields = header.names.size();
    for (std::size_t i = 0; i < header.fields; ++i) {
        const std::string place = where + ", column " + std::to_string(i + 1) + " (" + header.names[i] + ")";
        MOTE_ASSIGN_OR_RETURN(const auto meaning, fieldMeaning(header.names[i], mass, place));
        if (!meaning) continue;
        if (meaning->kind == FieldMeaning::Kind::column && header.find(meaning->column) != nullptr) {
            return Error{ErrorCode::corrupt, place, "means the same as a column before it"};
        }
        header.known.push_back({i, *meaning});
    }
    if (header.known.empty()) {
        return Error{ErrorCode::notFound, where, "names none of the columns x, y, z, t, px, py, pz"};
    }
    return header;
}

bool looksLikeHeader(std::string_view line) {
    const auto header = parseCsvHeader(line, 1.0, "");
    if (!header) return false;
    for (const std::string& name : header->names) {
        if (parseNumber(name)) return false;
    }
    return true;
}

Result<CsvHeader> readCsvHeader(const std::filesystem::path& path, double mass) {
    MOTE_ASSIGN_OR_RETURN(auto reader, LineReader::open(path));
    std::string comment, place;
    for (std::string_view line; reader.lineNumber() < maxCommentLines;) {
        MOTE_ASSIGN_OR_RETURN(const auto more, reader.next(line));
        if (!more) break;
        const std::string where = reader.name() + ": line " + std::to_string(reader.lineNumber());
        if (isRow(line)) {
            return comment.empty() || !fits(comment, line) ? parseCsvHeader(line, mass, where)
                                                           : commentHeader(comment, mass, place);
        }
        if (looksLikeHeader(line)) {
            comment = line;
            place = where;
        }
    }
    if (comment.empty())
        return Error{ErrorCode::notFound, reader.name(), "has no line with the columns' names"};
    return commentHeader(comment, mass, place);
}

Result<std::unique_ptr<ParticleSource>> openCsv(const std::vector<std::filesystem::path>& files, double mass,
                                                Progress& progress) {
    auto source = std::make_unique<CsvSource>(mass, progress);
    for (const std::filesystem::path& file : inOrder(files)) MOTE_RETURN_IF_ERROR(source->addFile(file));
    return std::unique_ptr<ParticleSource>(std::move(source));
}

}  // namespace mote::prep
