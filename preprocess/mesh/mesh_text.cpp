// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/mesh/mesh_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "preprocess/readers/text/number.h"

namespace mote::prep {
namespace {

constexpr std::string_view blanks = " \t\r\v\f";

std::string_view withoutBlanks(std::string_view text) {
    text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
    return text;
}

}  // namespace

bool MeshText::nextLine() {
    while (at_ < text_.size()) {
        const auto end = std::min(text_.find('\n', at_), text_.size());
        line_ = text_.substr(at_, end - at_);
        at_ = std::min(end + 1, text_.size());
        ++number_;
        line_ = withoutBlanks(line_.substr(0, line_.find('#')));
        line_ = line_.substr(0, line_.find_last_not_of(blanks) + 1);
        goesOn_ = line_.ends_with('\\');
        if (goesOn_) line_.remove_suffix(1);
        if (!line_.empty() || goesOn_) return true;
    }
    line_ = {};
    goesOn_ = false;
    return false;
}

std::string_view MeshText::word() {
    while (line_.empty() && goesOn_) {
        if (!nextLine()) return {};
    }
    const auto word = line_.substr(0, line_.find_first_of(blanks));
    line_.remove_prefix(word.size());
    line_ = withoutBlanks(line_);
    return word;
}

std::string_view MeshText::wordAcrossLines() {
    while (line_.empty()) {
        if (!nextLine()) return {};
    }
    return word();
}

std::optional<double> MeshText::number(std::string_view word) {
    return parseNumber(word);
}

std::optional<std::int64_t> MeshText::integer(std::string_view word) {
    if (word.starts_with('+')) word.remove_prefix(1);
    std::int64_t value = 0;
    const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (code != std::errc() || end != word.data() + word.size()) return std::nullopt;
    return value;
}

Result<glm::dvec3> MeshText::place() {
    glm::dvec3 place;
    for (int axis = 0; axis < 3; ++axis) {
        const auto value = number(word());
        if (!value) return error("a vertex needs three numbers");
        place[axis] = *value;
    }
    return place;
}

Error MeshText::error(std::string message) const {
    return corrupt(fmt::format("{}: line {}", name_, number_), std::move(message));
}

}  // namespace mote::prep
