// SPDX-License-Identifier: GPL-3.0-or-later
//
// JsonObject: one flat JSON object, member by member, for --json. (Not protobuf's Struct: its maps have
// another layout under the thread sanitizer than in the library.) A value.
#pragma once

#include <concepts>
#include <string>
#include <string_view>
#include <vector>

namespace mote::prep {

class JsonObject {
  public:
    JsonObject& add(std::string_view name, std::string_view text);
    JsonObject& add(std::string_view name, const char* text) { return add(name, std::string_view(text)); }
    JsonObject& add(std::string_view name, bool value);
    JsonObject& add(std::string_view name, double number);
    template <std::integral Number>
    requires(!std::same_as<Number, bool>) JsonObject& add(std::string_view name, Number number) {
        return addRaw(name, std::to_string(number));
    }
    JsonObject& add(std::string_view name, const std::vector<JsonObject>& objects);

    /// One line, without a newline.
    std::string text() const { return "{" + members_ + "}"; }

  private:
    JsonObject& addRaw(std::string_view name, std::string_view json);

    std::string members_;
};

}  // namespace mote::prep
