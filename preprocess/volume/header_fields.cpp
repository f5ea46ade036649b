// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/header_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "preprocess/readers/text/number.h"

namespace mote::prep {
namespace {

constexpr std::size_t maxNumbers = 64;

}  // namespace

std::string HeaderFields::plain(std::string_view name) {
    std::string plain;
    for (const char c : name) {
        if (c == ' ' || c == '\t') continue;
        plain += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    }
    return plain;
}

Status HeaderFields::add(std::string_view name, std::string_view value) {
    const bool added = fields_.emplace(plain(name), trim(value)).second;
    return added ? success() : Status(corrupt(name, "stands there twice"));
}

std::string_view HeaderFields::text(std::string_view name) const {
    const auto found = fields_.find(plain(name));
    return found == fields_.end() ? std::string_view() : found->second;
}

Result<std::vector<double>> HeaderFields::numbers(std::string_view name) const {
    std::array<std::string_view, maxNumbers> words;
    const std::size_t count = splitFields(text(name), ' ', words);
    if (count > maxNumbers) return corrupt(name, fmt::format("has more than {} numbers", maxNumbers));
    std::vector<double> numbers(count);
    for (std::size_t i = 0; i < count; ++i) {
        const auto number = parseNumber(words[i]);
        if (!number) return corrupt(name, fmt::format("\"{:.20}\" is no number", words[i]));
        numbers[i] = *number;
    }
    return numbers;
}

Result<std::vector<double>> HeaderFields::numbers(std::string_view name, std::size_t count) const {
    auto all = numbers(name);
    if (!all) return all.error();
    if (all->size() != count) {
        return corrupt(name, fmt::format("has {} numbers in place of {}", all->size(), count));
    }
    for (const double number : *all) {
        if (!std::isfinite(number)) return corrupt(name, fmt::format("says {}", number));
    }
    return all;
}

Result<std::vector<std::uint64_t>> HeaderFields::wholeNumbers(std::string_view name) const {
    MOTE_ASSIGN_OR_RETURN(const auto all, numbers(name));
    std::vector<std::uint64_t> whole;
    for (const double number : all) {
        if (!(number >= 0.0 && number < 0x1p53 && number == std::floor(number))) {
            return corrupt(name, fmt::format("says {}, which is no count", number));
        }
        whole.push_back(static_cast<std::uint64_t>(number));
    }
    return whole;
}

Result<std::uint64_t> HeaderFields::wholeNumber(std::string_view name, std::uint64_t otherwise) const {
    const auto all = wholeNumbers(name);
    if (!all) return all.error();
    if (all->size() > 1) return corrupt(name, fmt::format("has {} numbers in place of one", all->size()));
    return all->empty() ? otherwise : all->front();
}

Result<ScalarType> HeaderFields::type(std::string_view name, std::span<const ScalarTypeName> names) const {
    const std::string_view said = text(name);
    const auto found =
        std::find_if(names.begin(), names.end(), [&](const ScalarTypeName& one) { return one.name == said; });
    if (found != names.end()) return found->type;
    return unsupported(name,
                       fmt::format("\"{:.40}\" is no integer of 8, 16 or 32 bits, float or double", said));
}

bool HeaderFields::flag(std::string_view name, bool otherwise) const {
    const std::string_view said = text(name);
    if (said.empty()) return otherwise;
    return said.front() == 'T' || said.front() == 't' || said.front() == '1' || said.front() == 'Y' ||
           said.front() == 'y';
}

}  // namespace mote::prep
