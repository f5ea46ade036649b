// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/session/token.h"

#include <fmt/format.h>
#include <sys/random.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <system_error>

namespace mote::server {

std::string makeToken() {
    std::array<std::uint8_t, 32> bytes{};
    // The kernel gives up to 256 bytes whole once its generator is seeded.
    if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
        throw std::system_error(errno, std::generic_category(), "no random bytes for a token");
    }
    std::string text;
    for (const auto byte : bytes) text += fmt::format("{:02x}", byte);
    return text;
}

bool sameToken(std::string_view expected, std::string_view given) {
    if (expected.empty() || expected.size() != given.size()) return false;
    // volatile: the compiler must not leave the loop early.
    volatile unsigned char difference = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
        difference = static_cast<unsigned char>(difference | (expected[i] ^ given[i]));
    }
    return difference == 0;
}

}  // namespace mote::server
