// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/base/json_string.h"

#include <fmt/format.h>

#include "protocol/base/utf8.h"

namespace mote {

std::string jsonString(std::string_view text) {
    const auto valid = toUtf8(text);
    std::string_view rest = valid;
    std::string result = "\"";
    while (!rest.empty()) {
        const auto letter = rest.substr(0, characterLength(rest));
        if (letter == "\"" || letter == "\\") result += '\\';
        if (isControl(letter)) {
            // The last byte of U+0080 to U+009F is its number, as that of ASCII is.
            result += fmt::format("\\u{:04x}", static_cast<unsigned char>(letter.back()));
        } else {
            result += letter;
        }
        rest.remove_prefix(letter.size());
    }
    return result + '"';
}

}  // namespace mote
