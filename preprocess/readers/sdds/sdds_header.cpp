// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/sdds/sdds_header.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include "preprocess/readers/sdds/sdds_command.h"
#include "preprocess/readers/text/number.h"
#include "preprocess/readers/text/row_file.h"

namespace mote::prep {
namespace {

constexpr std::size_t maxCommandBytes = 64 * 1024;
constexpr std::size_t sddsMaxFields = 65536;
constexpr std::uint64_t maxLines = 1'000'000;
constexpr std::uint64_t maxHeaderLines = 100'000;
constexpr std::uint32_t maxDimensions = 32;

constexpr std::pair<std::string_view, SddsType> typeNames[] = {
    {"short", SddsType::int16},         {"ushort", SddsType::uint16},  {"long", SddsType::int32},
    {"ulong", SddsType::uint32},        {"long64", SddsType::int64},   {"ulong64", SddsType::uint64},
    {"float", SddsType::float32},       {"double", SddsType::float64}, {"longdouble", SddsType::longDouble},
    {"character", SddsType::character}, {"string", SddsType::string}};

bool digit(char c) {
    return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

/// The header while it is read, line by line.
class HeaderReader {
  public:
    explicit HeaderReader(LineReader lines) : lines_(std::move(lines)) {}
    Result<SddsHeader> read();

  private:
    std::string where() const { return lines_.name() + ": line " + std::to_string(lines_.lineNumber()); }
    Error corrupt(std::string message) const { return {ErrorCode::corrupt, where(), std::move(message)}; }
    Result<std::string_view> line();
    Status version();
    Status addLine(std::string_view line);
    Status take(const SddsCommand& command);
    Status addField(const SddsCommand& command, std::vector<SddsField>& fields);
    Status data(const SddsCommand& command);
    Status flag(const SddsCommand& command, const char* name, std::uint64_t most, std::uint64_t& value);
    Status check() const;

    LineReader lines_;
    SddsHeader header_;
    std::string pending_;  // a command that has no end yet
    bool complete_ = false;
    std::uint64_t additionalLines_ = 0;
};

Result<std::string_view> HeaderReader::line() {
    std::string_view line;
    MOTE_ASSIGN_OR_RETURN(const auto more, lines_.next(line));
    if (!more) {
        return Error{ErrorCode::corrupt, lines_.name(),
                     "is cut short at byte " + std::to_string(lines_.offset()) +
                         ", within its SDDS header (no &data command ends it)"};
    }
    return line;
}

Status HeaderReader::version() {
    MOTE_ASSIGN_OR_RETURN(const auto first, line());
    if (!looksLikeSdds(first)) return corrupt("is not the beginning of an SDDS data set (SDDS1 to SDDS5)");
    const auto number = parseId(trim(first.substr(4)));
    if (number && *number >= 1 && *number <= 5) return success();
    return unsupported(
        where(), "has the SDDS version '" + std::string(trim(first.substr(4, 16))) + "'; 1 to 5 are read");
}

Status HeaderReader::addLine(std::string_view line) {
    // Where a comment of the second line and the &data command differ, the command is the later one.
    if (line.starts_with("!#") && line.find("big-endian") != std::string_view::npos) header_.bigEndian = true;
    if (line.starts_with("!#") && line.find("little-endian") != std::string_view::npos)
        header_.bigEndian = false;
    // A comment does not begin in quotes, and those may have begun in an earlier line.
    if (!pending_.empty()) pending_ += ' ';
    pending_ += line;
    pending_ = std::string(trim(withoutSddsComment(pending_)));
    while (!complete_ && !pending_.empty()) {
        if (pending_.front() != '&') {
            return corrupt("has no command of an SDDS header where one should stand");
        }
        const auto end = sddsCommandEnd(pending_);
        if (!end && pending_.size() > maxCommandBytes) return corrupt("is in a command of more than 64 KiB");
        if (!end) break;
        MOTE_ASSIGN_OR_RETURN(const auto command, SddsCommand::parse(pending_.substr(0, *end), where()));
        MOTE_RETURN_IF_ERROR(take(command));
        pending_ = std::string(trim(std::string_view(pending_).substr(*end)));
    }
    return success();
}

Status HeaderReader::take(const SddsCommand& command) {
    if (command.name == "description" || command.name == "associate") return success();
    if (command.name == "parameter") return addField(command, header_.parameters);
    if (command.name == "array") return addField(command, header_.arrays);
    if (command.name == "column") return addField(command, header_.columns);
    if (command.name == "data") return data(command);
    if (command.name == "include") {
        return unsupported(
            where(), "includes another file (&include), which is not read; write the header out in full");
    }
    return corrupt("has the command '&" + command.name + "', which SDDS does not know");
}

Status HeaderReader::addField(const SddsCommand& command, std::vector<SddsField>& fields) {
    SddsField field;
    const std::string* name = command.find("name");
    if (name == nullptr || name->empty()) return corrupt("has a &" + command.name + " without a name");
    field.name = *name;
    const std::string what = "declares " + command.name + " '" + field.name + "' ";
    const auto same = [&](const SddsField& other) { return other.name == field.name; };
    if (std::find_if(fields.begin(), fields.end(), same) != fields.end()) return corrupt(what + "twice");
    const std::string* typeName = command.find("type");
    if (typeName == nullptr) return corrupt(what + "without a type");
    const auto* type = std::find_if(std::begin(typeNames), std::end(typeNames),
                                    [&](const auto& known) { return known.first == *typeName; });
    if (type == std::end(typeNames))
        return corrupt(what + "with the type '" + *typeName + "', which SDDS does not know");
    field.type = type->second;
    if (const std::string* units = command.find("units")) field.units = *units;
    if (const std::string* fixed = command.find("fixed_value");
        fixed != nullptr && command.name == "parameter") {
        field.fixedValue = *fixed;
    }
    for (std::size_t i = 0; i < std::size(sddsParameterNames); ++i) {
        if (command.name == "parameter" && sddsParameterNames[i] == field.name) field.known = i;
    }
    std::uint64_t dimensions = 1;
    MOTE_RETURN_IF_ERROR(flag(command, "dimensions", maxDimensions, dimensions));
    if (dimensions == 0) return corrupt(what + "with 0 dimensions");
    field.dimensions = static_cast<std::uint32_t>(dimensions);
    if (fields.size() == sddsMaxFields) return corrupt("declares more than 65536 fields of a kind");
    fields.push_back(std::move(field));
    return success();
}

Status HeaderReader::flag(const SddsCommand& command, const char* name, std::uint64_t most,
                          std::uint64_t& value) {
    const std::string* text = command.find(name);
    if (text == nullptr) return success();
    const auto number = parseId(*text);
    if (!number || *number > most) {
        return corrupt("has " + std::string(name) + "=" + *text + "; needs a whole number up to " +
                       std::to_string(most));
    }
    value = *number;
    return success();
}

Status HeaderReader::data(const SddsCommand& command) {
    const std::string* mode = command.find("mode");
    if (mode == nullptr || (*mode != "ascii" && *mode != "binary")) {
        return corrupt("has a &data command whose mode is neither ascii nor binary");
    }
    header_.ascii = *mode == "ascii";
    if (const std::string* endian = command.find("endian")) {
        if (*endian != "big" && *endian != "little")
            return corrupt("has endian=" + *endian + "; needs big or little");
        header_.bigEndian = *endian == "big";
    }
    std::uint64_t columnMajor = 0, noRowCounts = 0;
    MOTE_RETURN_IF_ERROR(flag(command, "column_major_order", 1, columnMajor));
    MOTE_RETURN_IF_ERROR(flag(command, "no_row_counts", 1, noRowCounts));
    MOTE_RETURN_IF_ERROR(flag(command, "lines_per_row", maxLines, header_.linesPerRow));
    MOTE_RETURN_IF_ERROR(flag(command, "additional_header_lines", maxLines, additionalLines_));
    header_.columnMajor = columnMajor != 0 && !header_.ascii;
    header_.noRowCounts = noRowCounts != 0 && header_.ascii;
    complete_ = true;
    return success();
}

Status HeaderReader::check() const {
    if (header_.ascii) return success();
    for (const auto* fields : {&header_.parameters, &header_.arrays, &header_.columns}) {
        for (const SddsField& field : *fields) {
            if (field.type != SddsType::longDouble || field.fixedValue) continue;
            return Error{
                ErrorCode::unsupported, lines_.name(),
                "holds '" + field.name +
                    "' as binary longdouble, whose bytes differ from machine to machine; convert it with "
                    "sddsprocess -cast or to ascii with sddsconvert"};
        }
    }
    return success();
}

Result<SddsHeader> HeaderReader::read() {
    MOTE_RETURN_IF_ERROR(version());
    while (!complete_) {
        MOTE_ASSIGN_OR_RETURN(const auto text, line());
        if (lines_.lineNumber() > maxHeaderLines) return corrupt("is still in the header");
        MOTE_RETURN_IF_ERROR(addLine(text));
    }
    for (std::uint64_t i = 0; i < additionalLines_; ++i) {
        if (const auto skipped = line(); !skipped) return skipped.error();
    }
    MOTE_RETURN_IF_ERROR(check());
    header_.dataOffset = lines_.offset();
    header_.dataLine = lines_.lineNumber();
    return std::move(header_);
}

}  // namespace

std::optional<StoredNumber> SddsField::stored() const {
    static constexpr StoredNumber types[] = {
        StoredNumber::int16, StoredNumber::uint16, StoredNumber::int32,   StoredNumber::uint32,
        StoredNumber::int64, StoredNumber::uint64, StoredNumber::float32, StoredNumber::float64};
    return type <= SddsType::float64 ? std::optional(types[static_cast<std::size_t>(type)]) : std::nullopt;
}

std::size_t SddsField::bytes() const {
    if (const auto number = stored()) return bytesOf(*number);
    return type == SddsType::character ? 1 : 0;
}

bool looksLikeSdds(std::string_view text) {
    if (!text.starts_with("SDDS")) return false;
    text.remove_prefix(4);
    while (text.starts_with(' ')) text.remove_prefix(1);
    return !text.empty() && digit(text.front());
}

Result<SddsHeader> SddsHeader::read(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(auto lines, LineReader::open(path));
    return HeaderReader(std::move(lines)).read();
}

}  // namespace mote::prep
