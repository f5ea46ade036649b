// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/metrics/http_answer.h"

#include <fmt/format.h>

namespace mote::server {
namespace {

std::string answer(std::string_view status, std::string_view type, std::string_view body,
                   std::string_view more = {}) {
    return fmt::format(
        "HTTP/1.1 {}\r\nContent-Type: {}\r\nContent-Length: {}\r\nCache-Control: no-store\r\n"
        "X-Content-Type-Options: nosniff\r\n{}Connection: close\r\n\r\n{}",
        status, type, body.size(), more, body);
}

std::string plain(std::string_view status, std::string_view sentence, std::string_view more = {}) {
    return answer(status, "text/plain; charset=utf-8", fmt::format("{}\n", sentence), more);
}

/// Up to a letter, which goes too.
std::string_view take(std::string_view& text, char end) {
    const auto word = text.substr(0, text.find(end));
    text.remove_prefix(std::min(text.size(), word.size() + 1));
    return word;
}

}  // namespace

std::string httpAnswer(std::string_view head, const HttpPages& pages) {
    auto line = head.substr(0, head.find("\r\n"));
    const auto method = take(line, ' '), target = take(line, ' ');
    if (line != "HTTP/1.1" && line != "HTTP/1.0") return plain("400 Bad Request", "this is no HTTP/1.1");
    if (method != "GET") return plain("405 Method Not Allowed", "only GET is answered", "Allow: GET\r\n");
    if (target == "/metrics") {
        return answer("200 OK", "text/plain; version=0.0.4; charset=utf-8", pages.metrics());
    }
    if (target != "/healthz") return plain("404 Not Found", "there are /metrics and /healthz");
    const auto trouble = pages.trouble();
    return trouble ? plain("503 Service Unavailable", *trouble) : plain("200 OK", "well");
}

std::string httpTooLong() {
    return plain("431 Request Header Fields Too Large", "the head of a request has at most 4096 bytes");
}

}  // namespace mote::server
