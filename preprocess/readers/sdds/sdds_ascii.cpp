// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <limits>
#include <string>
#include <string_view>

#include "preprocess/readers/sdds/sdds_command.h"
#include "preprocess/readers/sdds/sdds_pages.h"
#include "preprocess/readers/text/number.h"
#include "preprocess/readers/text/row_file.h"

namespace mote::prep {
namespace {

bool blank(char c) {
    return c == ' ' || c == '\t' || c == '\r';
}

/// Takes the next word, which may stand in quotes, from the front of `text`. False where none is left.
bool takeWord(std::string_view& text, std::string_view& word) {
    while (!text.empty() && blank(text.front())) text.remove_prefix(1);
    if (text.empty()) return false;
    const bool quoted = text.front() == '"';
    std::size_t end = quoted ? 1 : 0;
    while (end < text.size() && (quoted ? text[end] != '"' : !blank(text[end]))) {
        end += quoted && text[end] == '\\' ? 2 : 1;
    }
    end = std::min(end + (quoted ? 1 : 0), text.size());
    word = text.substr(0, end);
    text.remove_prefix(end);
    return true;
}

class AsciiPages : public SddsPages {
  public:
    AsciiPages(LineReader lines, const SddsHeader& header, Progress& progress)
        : lines_(std::move(lines)), header_(header), progress_(progress) {}
    Status scan();
    Status read(std::size_t page, std::uint64_t begin, std::size_t count,
                const std::vector<std::size_t>& columns, std::optional<std::size_t> idColumn,
                SddsRows& rows) override;

  private:
    struct Mark {
        std::uint64_t row = 0, offset = 0, lines = 0;
    };
    /// Where the values of a row go, by the columns of the file. Empty: nowhere.
    struct Target {
        std::vector<std::vector<double>*> values;
        std::vector<std::uint64_t>* ids = nullptr;
        std::size_t idColumn = 0, row = 0;
    };

    Error corrupt(std::string message) const {
        return {ErrorCode::corrupt, lines_.name() + ": line " + std::to_string(lines_.lineNumber()),
                std::move(message)};
    }
    Error cutShort(const std::string& within) const {
        return corrupt("is cut short: the file ends within " + within + " of page " +
                       std::to_string(pages_.size() + 1));
    }
    Status goTo(const Mark& mark);
    Result<bool> rawLine();
    Result<bool> line();
    Result<bool> fullLine();
    Result<bool> beginPage();
    Status scanParameters(SddsPage& page);
    Status scanArray(const SddsField& field);
    Result<std::uint64_t> count(const std::string& what);
    Status scanRows(SddsPage& page);
    Result<bool> beginRow();
    Status walkRow(Target* target);
    Status store(Target& target, std::size_t column, std::string_view word);

    LineReader lines_;
    SddsHeader header_;
    Progress& progress_;
    std::string_view line_;                 // without its comment; what is left of it, while a row is read
    std::uint64_t emptyLines_ = 0;          // before the page's first line: they may be empty texts
    std::optional<std::string_view> held_;  // the page's first line, to be handed out after those
    Mark lineBegin_;                        // of the line that was read last
    bool atLineBegin_ = true;               // the row that has begun
    std::vector<std::vector<Mark>> marks_;  // by page
    // The row that comes next without a way back.
    std::size_t nextPage_ = std::numeric_limits<std::size_t>::max();
    std::uint64_t nextRow_ = 0;
};

/// Goes to the beginning of a line; a compressed file is read again where that lies behind.
Status AsciiPages::goTo(const Mark& mark) {
    line_ = {};
    held_.reset();
    emptyLines_ = 0;
    if (!lines_.compressed()) return lines_.seek(mark.offset, mark.lines);
    if (lines_.lineNumber() > mark.lines) MOTE_RETURN_IF_ERROR(lines_.seek(0, 0));
    for (std::string_view text; lines_.lineNumber() < mark.lines;) {
        if (lines_.lineNumber() % sddsRowsPerMark == 0 && progress_.cancelled())
            return wasCancelled("cancelled while a table was read");
        MOTE_ASSIGN_OR_RETURN(const auto more, lines_.next(text));
        if (!more) return corrupt("has changed since it was opened");
    }
    return success();
}

/// The next line that is no comment, without what is a comment in it.
Result<bool> AsciiPages::rawLine() {
    for (std::string_view text;;) {
        lineBegin_ = {0, lines_.offset(), lines_.lineNumber()};
        if (lines_.lineNumber() % sddsRowsPerMark == 0 && progress_.cancelled())
            return wasCancelled("cancelled while a table was read");
        MOTE_ASSIGN_OR_RETURN(const auto more, lines_.next(text));
        if (!more) return false;
        line_ = trim(withoutSddsComment(text));
        if (!line_.empty() || trim(text).empty()) return true;
    }
}

Result<bool> AsciiPages::line() {
    line_ = {};
    if (emptyLines_ > 0) {
        --emptyLines_;
        return true;
    }
    if (!held_) return rawLine();
    line_ = *held_;
    held_.reset();
    return true;
}

Result<bool> AsciiPages::fullLine() {
    do {
        auto more = line();
        if (!more || !*more) return more;
    } while (line_.empty());
    return true;
}

/// Whether another page follows. What is blank up to the file's end is none.
Result<bool> AsciiPages::beginPage() {
    held_.reset();
    for (emptyLines_ = 0;; ++emptyLines_) {
        auto more = rawLine();
        if (!more || !*more) return more;
        if (line_.empty()) continue;
        held_ = line_;
        return true;
    }
}

Status AsciiPages::scan() {
    MOTE_RETURN_IF_ERROR(goTo({0, header_.dataOffset, header_.dataLine}));
    for (;;) {
        MOTE_ASSIGN_OR_RETURN(const auto more, beginPage());
        if (!more) return success();
        if (pages_.size() == maxSddsPages) return corrupt("begins one page more than 100000");
        SddsPage page;
        MOTE_RETURN_IF_ERROR(scanParameters(page));
        for (const SddsField& array : header_.arrays) MOTE_RETURN_IF_ERROR(scanArray(array));
        marks_.emplace_back();
        if (!header_.columns.empty()) MOTE_RETURN_IF_ERROR(scanRows(page));
        pages_.push_back(page);
    }
}

Status AsciiPages::scanParameters(SddsPage& page) {
    for (const SddsField& field : header_.parameters) {
        double value = std::numeric_limits<double>::quiet_NaN();
        if (field.fixedValue) {
            value = parseNumber(*field.fixedValue).value_or(value);
        } else {
            auto more = field.number() ? fullLine() : line();
            if (!more) return more.error();
            if (!*more) return cutShort("parameter '" + field.name + "'");
        }
        if (field.number() && !field.fixedValue) {
            std::string_view rest = line_, word;
            const auto number = takeWord(rest, word) ? parseNumber(word) : std::nullopt;
            if (!number) {
                return corrupt("has '" + std::string(line_.substr(0, 40)) +
                               "' in place of the number of parameter '" + field.name + "'");
            }
            value = *number;
        }
        if (field.known) page.parameters[*field.known] = value;
    }
    return success();
}

Result<std::uint64_t> AsciiPages::count(const std::string& what) {
    MOTE_ASSIGN_OR_RETURN(const auto more, fullLine());
    if (!more) return cutShort(what);
    const auto number = parseId(line_);
    if (number) return *number;
    return corrupt("has '" + std::string(line_.substr(0, 40)) + "' in place of " + what);
}

Status AsciiPages::scanArray(const SddsField& field) {
    const std::string what = "array '" + field.name + "'";
    MOTE_ASSIGN_OR_RETURN(const auto more, fullLine());
    if (!more) return cutShort(what);
    std::string_view rest = line_, word;
    std::uint64_t values = 1;
    for (std::uint32_t i = 0; i < field.dimensions; ++i) {
        const auto length = takeWord(rest, word) ? parseId(word) : std::nullopt;
        if (!length || (*length > 0 && values > std::numeric_limits<std::uint64_t>::max() / *length)) {
            return corrupt("has no size of " + what + " where one should stand");
        }
        values *= *length;
    }
    for (rest = {}; values > 0; --values) {
        while (!takeWord(rest, word)) {
            MOTE_ASSIGN_OR_RETURN(const auto found, fullLine());
            if (!found) return cutShort(what);
            rest = line_;
        }
    }
    return success();
}

Status AsciiPages::scanRows(SddsPage& page) {
    std::uint64_t declared = std::numeric_limits<std::uint64_t>::max();
    if (!header_.noRowCounts) {
        MOTE_ASSIGN_OR_RETURN(declared, count("the number of rows"));
    }
    if (header_.noRowCounts) emptyLines_ = 0;
    line_ = {};
    std::vector<Mark>& marks = marks_.back();
    for (; page.rows < declared; ++page.rows) {
        MOTE_ASSIGN_OR_RETURN(const auto begun, beginRow());
        if (!begun && header_.noRowCounts) break;
        if (!begun) {
            return corrupt("is cut short: page " + std::to_string(pages_.size() + 1) + " declares " +
                           std::to_string(declared) + " rows and has " + std::to_string(page.rows));
        }
        if (atLineBegin_ && (marks.empty() || page.rows - marks.back().row >= sddsRowsPerMark)) {
            marks.push_back({page.rows, lineBegin_.offset, lineBegin_.lines});
        }
        MOTE_RETURN_IF_ERROR(walkRow(nullptr));
    }
    return success();
}

/// Whether there is another row; line_ then begins with it.
Result<bool> AsciiPages::beginRow() {
    atLineBegin_ = header_.linesPerRow != 0 || line_.empty();
    if (!atLineBegin_) return true;
    auto more = header_.noRowCounts ? line() : fullLine();
    if (!more || !*more) return more;
    return !line_.empty();
}

/// Steps over the row that line_ begins with; its values go to `target`, where there is one.
Status AsciiPages::walkRow(Target* target) {
    std::uint64_t lines = 1;
    std::string_view word;
    for (std::size_t column = 0; column < header_.columns.size(); ++column) {
        while (!takeWord(line_, word)) {
            if (lines == header_.linesPerRow) {
                return corrupt("has " + std::to_string(column) + " values in a row of " +
                               std::to_string(header_.columns.size()) + " columns");
            }
            MOTE_ASSIGN_OR_RETURN(const auto more, rawLine());
            if (!more) return cutShort("a row");
            ++lines;
        }
        if (target != nullptr) MOTE_RETURN_IF_ERROR(store(*target, column, word));
    }
    if (header_.linesPerRow == 0) return success();
    if (!line_.empty()) {
        return corrupt("has more values than the data set has columns, " +
                       std::to_string(header_.columns.size()));
    }
    for (; lines < header_.linesPerRow; ++lines) {
        MOTE_ASSIGN_OR_RETURN(const auto more, rawLine());
        if (!more) return cutShort("a row");
    }
    return success();
}

Status AsciiPages::store(Target& target, std::size_t column, std::string_view word) {
    std::vector<double>* values = target.values[column];
    const bool id = target.ids != nullptr && target.idColumn == column;
    if (values == nullptr && !id) return success();
    const auto number = parseNumber(word);
    if (!number) {
        return corrupt("has '" + std::string(word.substr(0, 40)) + "' in place of a number of column '" +
                       header_.columns[column].name + "'");
    }
    if (values != nullptr) (*values)[target.row] = *number;
    if (id) (*target.ids)[target.row] = parseId(word).value_or(0);
    return success();
}

Status AsciiPages::read(std::size_t page, std::uint64_t begin, std::size_t count,
                        const std::vector<std::size_t>& columns, std::optional<std::size_t> idColumn,
                        SddsRows& rows) {
    Target target;
    target.values.resize(header_.columns.size());
    rows.columns.resize(columns.size());
    for (std::size_t i = 0; i < columns.size(); ++i) {
        rows.columns[i].resize(count);
        target.values[columns[i]] = &rows.columns[i];
    }
    rows.ids.resize(idColumn ? count : 0);
    if (idColumn) target.ids = &rows.ids;
    target.idColumn = idColumn.value_or(0);
    if (count == 0) return success();
    if (nextPage_ != page || nextRow_ > begin || begin - nextRow_ > sddsRowsPerMark) {
        const std::vector<Mark>& marks = marks_[page];
        const auto after =
            std::upper_bound(marks.begin(), marks.end(), begin,
                             [](std::uint64_t row, const Mark& mark) { return row < mark.row; });
        MOTE_RETURN_IF_ERROR(goTo(*std::prev(after)));
        nextRow_ = std::prev(after)->row;
    }
    nextPage_ = std::numeric_limits<std::size_t>::max();  // until all went well
    for (; nextRow_ < begin + count; ++nextRow_) {
        MOTE_ASSIGN_OR_RETURN(const auto begun, beginRow());
        if (!begun) return corrupt("has changed since it was opened");
        target.row = static_cast<std::size_t>(nextRow_ - std::min(nextRow_, begin));
        MOTE_RETURN_IF_ERROR(walkRow(nextRow_ < begin ? nullptr : &target));
    }
    nextPage_ = page;
    return success();
}

}  // namespace

Result<std::unique_ptr<SddsPages>> openSddsAscii(const std::filesystem::path& path, const SddsHeader& header,
                                                 Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(auto lines, LineReader::open(path));
    auto pages = std::make_unique<AsciiPages>(std::move(lines), header, progress);
    MOTE_RETURN_IF_ERROR(pages->scan());
    return std::unique_ptr<SddsPages>(std::move(pages));
}

}  // namespace mote::prep
