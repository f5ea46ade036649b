// SPDX-License-Identifier: GPL-3.0-or-later
//
// ShapedLink: a socket that behaves like a long thin line to another one: bytes pass in their order at a
// rate, arrive after a delay, and where too many wait the sender is held up. The same both ways, each way on
// its own; any number of connections, which do not share the rate. It owns a thread; destroying it closes
// all.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>

namespace mote::test {

struct LinkShape {
    double bitsPerSecond = 20e6;
    std::chrono::milliseconds oneWay{50};
    std::size_t mostWaiting = 256 << 10;  ///< bytes that wait for the rate; those under way come on top
};

class ShapedLink {
  public:
    /// Listens at `from` (made, removed at the end), connects each client to `to`: paths of Unix sockets.
    /// Throws std::runtime_error if it cannot listen.
    ShapedLink(std::filesystem::path from, std::filesystem::path to, const LinkShape& shape);
    ~ShapedLink();
    ShapedLink(const ShapedLink&) = delete;
    ShapedLink& operator=(const ShapedLink&) = delete;

    /// From now on; for what is under way too.
    void reshape(double bitsPerSecond);

  private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace mote::test
