// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/config_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <numeric>

#include "server/app/server_option.h"
#define TOML_EXCEPTIONS 0
#define TOML_HEADER_ONLY 1
#include <toml++/toml.h>

namespace mote::server {
namespace {

// More is no configuration of ours, and would be read into memory.
constexpr std::uintmax_t mostBytes = std::uintmax_t{1} << 20;

/// How many letters must change to make one word of another (Levenshtein).
std::size_t distance(std::string_view one, std::string_view other) {
    std::vector<std::size_t> row(other.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < one.size(); ++i) {
        std::size_t before = std::exchange(row[0], i + 1);
        for (std::size_t j = 0; j < other.size(); ++j) {
            const std::size_t changed = before + (one[i] == other[j] ? 0 : 1);
            before = row[j + 1];
            row[j + 1] = std::min({changed, row[j] + 1, before + 1});
        }
    }
    return row.back();
}

/// "there is no option "thread"; is "threads" meant?"
std::string unknown(std::string_view key) {
    std::string text = fmt::format("there is no option \"{}\"", key.substr(0, 64));
    if (key.size() > 64) return text;
    const auto nearest = std::ranges::min(
        serverOptions(), {}, [key](const ServerOption& option) { return distance(key, option.name); });
    const bool near = distance(key, nearest.name) <= std::max<std::size_t>(2, key.size() / 3);
    return near ? fmt::format("{}; is \"{}\" meant?", text, nearest.name) : text;
}

const char* kindOf(const ServerOption& option) {
    if (option.isFlag()) return "true or false";
    return option.isNumber() ? "a whole number" : "a text";
}

/// The value as the command line would hold it; nothing where it is of another type.
std::optional<std::string> textOf(const toml::node& node, const ServerOption& option) {
    if (option.isFlag()) {
        const auto flag = node.value_exact<bool>();
        return flag ? std::optional<std::string>(*flag ? "true" : "false") : std::nullopt;
    }
    if (option.isNumber()) {
        const auto number = node.value_exact<std::int64_t>();
        return number ? std::optional(std::to_string(*number)) : std::nullopt;
    }
    return node.value_exact<std::string>();
}

Result<std::vector<std::string>> valuesOf(const toml::node& node, const ServerOption& option) {
    const auto wrong = [&] {
        return invalid("", option.isList()
                               ? fmt::format("\"{}\" must be a list of \"{}\"", option.name, option.valueName)
                               : fmt::format("\"{}\" must be {}", option.name, kindOf(option)));
    };
    std::vector<std::string> values;
    const auto add = [&](const toml::node& element) {
        auto text = textOf(element, option);
        if (!text) return false;
        values.push_back(*std::move(text));
        return true;
    };
    if (!option.isList()) {
        if (!add(node)) return wrong();
        return values;
    }
    const auto* array = node.as_array();
    if (!array || !std::ranges::all_of(*array, add)) return wrong();
    return values;
}

}  // namespace

Result<std::map<std::string, ConfigValue>> readConfig(const std::string& path) {
    std::error_code code;
    if (!std::filesystem::is_regular_file(path, code)) {
        return Error{ErrorCode::notFound, path, "there is no such configuration file"};
    }
    if (std::filesystem::file_size(path, code) > mostBytes) {
        return invalid(path, "a configuration file is not that large");
    }
    const auto parsed = toml::parse_file(path);
    const auto placeOf = [&](const toml::source_region& source) {
        return fmt::format("{}:{}", path, source.begin.line);
    };
    if (!parsed) {
        return invalid(placeOf(parsed.error().source()), std::string(parsed.error().description()));
    }
    std::map<std::string, ConfigValue> known;
    for (const auto& [key, node] : parsed.table()) {
        const auto where = placeOf(key.source());
        const auto* option = findOption(key.str());
        if (option == nullptr) return invalid(where, unknown(key.str()));
        auto values = valuesOf(node, *option);
        if (!values.ok()) return invalid(where, values.error().message);
        known[option->name] = {*std::move(values), where};
    }
    return known;
}

}  // namespace mote::server
