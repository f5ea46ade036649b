// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/csv/csv_header.h"

#include <array>

#include "preprocess/readers/text/line_reader.h"
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
    auto names = namesOf(line, header.separator, where);
    if (!names) return names.error();
    header.names = std::move(*names);
    header.fields = header.names.size();
    for (std::size_t i = 0; i < header.fields; ++i) {
        const std::string place = where + ", column " + std::to_string(i + 1) + " (" + header.names[i] + ")";
        const auto meaning = fieldMeaning(header.names[i], mass, place);
        if (!meaning) return meaning.error();
        if (!*meaning) continue;
        if ((*meaning)->kind == FieldMeaning::Kind::column && header.find((*meaning)->column) != nullptr) {
            return Error{ErrorCode::corrupt, place, "means the same as a column before it"};
        }
        header.known.push_back({i, **meaning});
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
    auto reader = LineReader::open(path);
    if (!reader) return reader.error();
    std::string comment, place;
    for (std::string_view line; reader->lineNumber() < maxCommentLines;) {
        const auto more = reader->next(line);
        if (!more) return more.error();
        if (!*more) break;
        const std::string where = reader->name() + ": line " + std::to_string(reader->lineNumber());
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
        return Error{ErrorCode::notFound, reader->name(), "has no line with the columns' names"};
    return commentHeader(comment, mass, place);
}

}  // namespace mote::prep
