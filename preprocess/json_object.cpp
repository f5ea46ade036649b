// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/json_object.h"

#include <fmt/format.h>

namespace mote::prep {
namespace {

std::string quoted(std::string_view text) {
    std::string result = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') {
            result += '\\';
            result += c;
        } else if (static_cast<unsigned char>(c) < 0x20) {
            result += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
        } else {
            result += c;
        }
    }
    return result + "\"";
}

}  // namespace

JsonObject& JsonObject::addRaw(std::string_view name, std::string_view json) {
    members_ += fmt::format("{}{}: {}", members_.empty() ? "" : ", ", quoted(name), json);
    return *this;
}

JsonObject& JsonObject::add(std::string_view name, std::string_view text) {
    return addRaw(name, quoted(text));
}

JsonObject& JsonObject::add(std::string_view name, bool value) {
    return addRaw(name, value ? "true" : "false");
}

JsonObject& JsonObject::add(std::string_view name, double number) {
    return addRaw(name, fmt::format("{}", number));
}

JsonObject& JsonObject::add(std::string_view name, const std::vector<JsonObject>& objects) {
    std::string list;
    for (const auto& object : objects) list += (list.empty() ? "" : ", ") + object.text();
    return addRaw(name, "[" + list + "]");
}

}  // namespace mote::prep
