// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cctype>
#include <optional>

#include "preprocess/readers/csv/csv_header.h"
#include "preprocess/readers/text/number.h"
#include "preprocess/readers/text/row_file.h"
#include "protocol/scene/utf8.h"

namespace mote::prep {
namespace {

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
    return header;
}

}  // namespace

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

}  // namespace mote::prep
