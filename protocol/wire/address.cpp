// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/wire/address.h"

#include <fmt/format.h>

#include <charconv>

namespace mote::wire {
namespace {

Error invalid(std::string_view text, std::string message) {
    return {ErrorCode::invalidArgument, std::string(text.substr(0, 200)), std::move(message)};
}

Result<Address> parseUnix(std::string_view text, std::string_view path) {
    if (path.empty()) return invalid(text, "the socket's path is missing");
    if (path.find('\0') != std::string_view::npos) return invalid(text, "a path has no zero byte");
    if (path.size() > maxSocketPath) {
        return invalid(text, fmt::format("a socket's path has at most {} bytes, not {}; use a shorter folder",
                                         maxSocketPath, path.size()));
    }
    return Address{Address::Kind::unixSocket, std::string(path), {}, 0};
}

Result<Address> parseTcp(std::string_view text, std::string_view rest) {
    const auto colon = rest.rfind(':');
    if (colon == std::string_view::npos) return invalid(text, "a port is missing: tcp:HOST:PORT");
    std::string_view host = rest.substr(0, colon);
    const std::string_view digits = rest.substr(colon + 1);
    if (host.size() >= 2 && host.front() == '[' && host.back() == ']') {
        host = host.substr(1, host.size() - 2);
    } else if (host.find(':') != std::string_view::npos) {
        return invalid(text, "an IPv6 address stands in brackets: tcp:[::1]:PORT");
    }
    if (host.empty() || host.size() > 255) return invalid(text, "a host is missing: tcp:HOST:PORT");
    std::uint16_t port = 0;
    const auto parsed = std::from_chars(digits.data(), digits.data() + digits.size(), port);
    if (parsed.ec != std::errc{} || parsed.ptr != digits.data() + digits.size()) {
        return invalid(text, "a port is a number from 0 to 65535");
    }
    return Address{Address::Kind::tcp, {}, std::string(host), port};
}

}  // namespace

std::string Address::toString() const {
    if (kind == Kind::unixSocket) return "unix:" + path;
    const bool brackets = host.find(':') != std::string::npos;
    return fmt::format("tcp:{}{}{}:{}", brackets ? "[" : "", host, brackets ? "]" : "", port);
}

Result<Address> parseAddress(std::string_view text) {
    constexpr std::string_view unixPrefix = "unix:";
    constexpr std::string_view tcpPrefix = "tcp:";
    if (text.starts_with(unixPrefix)) return parseUnix(text, text.substr(unixPrefix.size()));
    if (text.starts_with(tcpPrefix)) return parseTcp(text, text.substr(tcpPrefix.size()));
    return invalid(text, "an address is unix:PATH or tcp:HOST:PORT");
}

}  // namespace mote::wire
