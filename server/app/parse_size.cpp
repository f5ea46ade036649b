// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/parse_size.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <string_view>

namespace mote::server {

Result<std::uint64_t> parseSize(const std::string& text) {
    double number = 0.0;
    const auto [rest, code] = std::from_chars(text.data(), text.data() + text.size(), number);
    std::string unit(rest, text.data() + text.size());
    for (auto& c : unit) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    if (unit.ends_with("IB")) unit.resize(unit.size() - 2);
    if (unit.ends_with("B")) unit.pop_back();
    constexpr std::string_view units = "KMGT";
    const std::size_t power = unit.empty() ? 0 : units.find(unit) + 1;  // 0 where there is no such unit
    const bool known = unit.empty() || (unit.size() == 1 && power > 0);
    const double bytes = number * std::pow(1024.0, static_cast<double>(power));
    if (code != std::errc{} || !known || !(bytes >= 1.0 && bytes < 0x1p62)) {
        return Error{ErrorCode::invalidArgument, "", fmt::format("\"{}\" is no size such as 8G", text)};
    }
    return static_cast<std::uint64_t>(bytes);
}

}  // namespace mote::server
