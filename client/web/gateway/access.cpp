// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/web/gateway/access.h"

#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <system_error>

namespace mote::web {
namespace {

constexpr std::size_t mostTokens = 64;
constexpr long cookieSeconds = 30L * 24 * 3600;  // it ends with our process anyway

std::string randomHex(std::size_t bytes) {
    std::array<std::uint8_t, 32> random{};
    MOTE_CHECK(bytes <= random.size());
    if (::getrandom(random.data(), bytes, 0) != static_cast<ssize_t>(bytes))
        throw std::system_error(errno, std::generic_category(), "no random bytes for a token");
    std::string text;
    for (std::size_t i = 0; i < bytes; ++i) text += fmt::format("{:02x}", random[i]);
    return text;
}

/// In a time that does not tell where they differ.
bool sameSecret(std::string_view expected, std::string_view given) {
    if (expected.size() != given.size()) return false;
    volatile unsigned char difference = 0;
    for (std::size_t i = 0; i < expected.size(); ++i)
        difference = static_cast<unsigned char>(difference | (expected[i] ^ given[i]));
    return difference == 0;
}

std::string_view trimmedCookie(std::string_view text) {
    while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
    while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
    return text;
}

bool isLoopback(std::string_view name) {
    return name == "127.0.0.1" || name == "localhost" || name == "[::1]";
}

std::string_view hostOfOrigin(std::string_view origin) {
    const auto at = origin.find("://");
    return at == std::string_view::npos ? std::string_view() : origin.substr(at + 3);
}

bool isHostText(std::string_view text) {
    return !text.empty() && text.size() <= 300 && std::ranges::all_of(text, [](char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.' ||
               c == '-' || c == ':' || c == '[' || c == ']' || c == '_';
    });
}

}  // namespace

std::string_view hostName(std::string_view host) {
    const auto bracket = host.rfind(']');
    const auto colon = host.rfind(':');
    const bool port =
        colon != std::string_view::npos && (bracket == std::string_view::npos || colon > bracket);
    return port ? host.substr(0, colon) : host;
}

bool isOrigin(std::string_view text) {
    const bool scheme = text.starts_with("http://") || text.starts_with("https://");
    auto host = hostOfOrigin(text);
    if (host.ends_with(":*")) host.remove_suffix(2);
    return scheme && isHostText(host);
}

Access::Access(AccessSettings settings)
    : settings_(std::move(settings)),
      // Browsers do not tell ports apart: two of us on one machine have cookies of different names.
      cookieName_("mote-" + randomHex(4)),
      ownerSecret_(randomHex(32)),
      followerSecret_(randomHex(32)) {}

std::string Access::makeToken(Role role) {
    if (tokens_.size() == mostTokens) tokens_.pop_front();
    tokens_.emplace_back(randomHex(32), role);
    return tokens_.back().first;
}

Role Access::useToken(std::string_view token) {
    const auto found =
        std::ranges::find_if(tokens_, [&](const auto& each) { return sameSecret(each.first, token); });
    if (found == tokens_.end()) return Role::nobody;
    const auto role = found->second;
    tokens_.erase(found);
    return role;
}

std::string Access::cookie(Role role, bool secure) const {
    return fmt::format("{}={}; Max-Age={}; HttpOnly; SameSite=Strict{}", cookieName_,
                       role == Role::owner ? ownerSecret_ : followerSecret_, cookieSeconds,
                       secure || settings_.encrypted ? "; Secure" : "");
}

Role Access::roleOf(const Caller& caller) const {
    const auto most = settings_.readOnly ? Role::follower : Role::owner;
    if (settings_.trusting) return most;
    auto rest = caller.cookies;
    auto role = Role::nobody;
    while (!rest.empty()) {
        const auto end = rest.find(';');
        const auto pair = trimmedCookie(rest.substr(0, end));
        rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
        const auto equals = pair.find('=');
        if (equals == std::string_view::npos || pair.substr(0, equals) != cookieName_) continue;
        const auto value = pair.substr(equals + 1);
        if (sameSecret(ownerSecret_, value)) role = most;
        if (sameSecret(followerSecret_, value) && role == Role::nobody) role = Role::follower;
    }
    return role;
}

bool Access::knowsHost(std::string_view host) const {
    if (!isHostText(host)) return false;
    if (settings_.anyHost || isLoopback(hostName(host))) return true;
    const auto is = [&](std::string_view own) { return own == host; };
    return std::ranges::any_of(settings_.hosts, is) ||
           std::ranges::any_of(settings_.origins,
                               [&](const auto& origin) { return is(hostOfOrigin(origin)); });
}

bool Access::knowsOrigin(const Caller& caller) const {
    if (!isOrigin(caller.origin)) return false;
    if (std::ranges::find(settings_.origins, caller.origin) != settings_.origins.end()) return true;
    const auto host = hostOfOrigin(caller.origin);
    // A proxy that a page talks to says whose host it stands for; a page cannot set that.
    return host == caller.host ||
           (settings_.anyHost && settings_.origins.empty() && host == caller.forwardedHost);
}

std::optional<std::string_view> Access::pathBelowBase(std::string_view path) const {
    const std::string_view base = settings_.basePath;
    if (path.starts_with(base)) return path.substr(base.size() - 1);
    if (path == base.substr(0, base.size() - 1)) return std::nullopt;
    return path;
}

std::string Access::policy(std::string_view host) const {
    std::string ancestors = "'self'";
    for (const auto& each : settings_.frameAncestors) ancestors += " " + each;
    // Not every browser takes a WebSocket to our own host for 'self'.
    const auto sockets = isHostText(host) ? fmt::format(" ws://{0} wss://{0}", host) : std::string();
    return fmt::format(
        "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; img-src 'self' blob:; "
        "connect-src 'self'{}; worker-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors {}",
        sockets, ancestors);
}

Status Access::mayAsk(Role role, const proto::ClientMessage& message) {
    using Message = proto::ClientMessage;
    if (role == Role::owner) return success();
    switch (message.body_case()) {
        case Message::kHello:
        case Message::kSetView:
        case Message::kCredit:
        case Message::kListDatasets:
        case Message::kDescribe:
        case Message::kGetThumbnail:
        case Message::kListLoaded:
        case Message::kPing:
        case Message::kPong:
        case Message::kQuery:
        case Message::kCancelQuery:
        case Message::kListSessions:
        case Message::kFollow:
            return success();
        default:
            return Error{ErrorCode::permissionDenied, "message", "this link is for looking only"};
    }
}

}  // namespace mote::web
