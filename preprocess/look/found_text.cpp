// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cmath>

#include "preprocess/look/found.h"
#include "protocol/base/json_string.h"

namespace mote::prep {
namespace {

std::string json(const std::string& text) {
    return jsonString(text);
}
std::string json(double number) {
    return std::isfinite(number) ? fmt::format("{}", number) : "null";
}
std::string json(std::uint64_t number) {
    return fmt::format("{}", number);
}
std::string json(std::int64_t number) {
    return fmt::format("{}", number);
}
std::string json(bool yes) {
    return yes ? "true" : "false";
}
std::string json(const FoundColumn& column) {
    return fmt::format(R"({{"name": {}, "unit": {}, "min": {}, "max": {}, "invalid": {}}})",
                       json(column.name), json(column.unit), json(column.low), json(column.high),
                       column.invalid);
}

std::string json(const Fact& fact) {
    return fmt::format(R"({{"label": {}, "text": {}}})", json(fact.label), json(fact.text));
}

std::string json(const Found& found);

template <class T>
std::string json(const std::vector<T>& values) {
    std::string list;
    for (const T& value : values) list += (list.empty() ? "" : ", ") + json(value);
    return "[" + list + "]";
}

std::string json(const Found& found) {
    std::string text = fmt::format(R"({{"kind": {}, "format": {}, "toldBy": {})", json(found.kind),
                                   json(found.format), json(found.told));
    if (!found.name.empty()) text += ", \"name\": " + json(found.name);
    for (const Fact& fact : found.facts) {
        text += fmt::format(", {}: {}", json(fact.name),
                            std::visit([](const auto& value) { return json(value); }, fact.value));
    }
    std::vector<Fact> lines;
    for (const Fact& fact : found.facts) {
        if (!fact.text.empty()) lines.push_back(fact);
    }
    return text + fmt::format(R"(, "lines": {}, "columns": {}, "notes": {}, "refused": {}}})", json(lines),
                              json(found.columns), json(found.notes), json(found.refused));
}

void addLine(std::string& text, const std::string& label, const std::string& rest) {
    text += fmt::format("  {:<8} {}\n", label, rest);
}

std::string rangeText(const FoundColumn& column) {
    std::string text = "has no finite value";
    if (std::isfinite(column.low)) {
        text = column.low < column.high ? fmt::format("from {:.6g} to {:.6g}", column.low, column.high)
                                        : fmt::format("{:.6g} everywhere", column.low);
        if (!column.unit.empty() && column.unit != "1") text += " " + column.unit;
    }
    if (column.invalid > 0) text += fmt::format(", {} not finite", column.invalid);
    return text;
}

std::string describe(const Found& found) {
    std::string text;
    for (const Fact& fact : found.facts) {
        if (!fact.text.empty()) addLine(text, fact.label, fact.text);
    }
    const bool named = found.kind == "particles" || found.kind == "mesh";
    const char* const label = found.kind == "particles" ? "column"
                              : found.kind == "mesh"    ? "bounds"
                                                        : "values";
    for (const FoundColumn& column : found.columns)
        addLine(text, label, (named ? column.name + " " : "") + rangeText(column));
    for (const std::string& note : found.notes) addLine(text, "note", note);
    for (const std::string& sentence : found.refused) addLine(text, "refused", sentence);
    return text;
}

}  // namespace

std::string jsonLine(const Look& look) {
    return fmt::format(R"({{"input": {}, "found": {}, "refused": {}}})", json(look.input), json(look.found),
                       json(look.refused)) +
           "\n";
}

std::string lookText(const Look& look) {
    std::string text;
    for (const Found& found : look.found) {
        text += fmt::format("{}: {}{} ({}: {})\n", look.input, found.kind,
                            found.name.empty() ? "" : " '" + found.name + "'", found.format, found.told);
        text += describe(found);
    }
    if (look.found.empty()) text += look.input + ": nothing that is read\n";
    for (const std::string& sentence : look.refused) addLine(text, "refused", sentence);
    return text;
}

}  // namespace mote::prep
