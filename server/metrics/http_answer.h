// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is answered to a request of HTTP/1.1 for /metrics or /healthz, and to all others. A pure function.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace mote::server {

/// Asked only where a request needs it.
struct HttpPages {
    std::function<std::string()> metrics;
    std::function<std::optional<std::string>()> trouble;  ///< why the server is not well; nothing: it is
};

/// A request's head is no longer, in bytes.
constexpr std::size_t longestHttpHead = 4096;

/// The whole answer to a request's head, which ends with an empty line; whatever its bytes. The connection
/// closes after it.
std::string httpAnswer(std::string_view head, const HttpPages& pages);

/// The answer to a head that does not end.
std::string httpTooLong();

}  // namespace mote::server
