// SPDX-License-Identifier: GPL-3.0-or-later
//
// Order: what mote-supervise is to do, as its command line says. A value; RunOrder (server/jobs/runner.h) is
// what the server makes it from.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/jobs/supervise/rights.h"

namespace mote::server {

struct Order {
    std::string directory;
    Rights rights;
    std::uint32_t timeLimit = 0;  ///< s; 0: none
    bool gate = true;             ///< wait for the byte
    bool publishes = false;       ///< what it makes is given its place afterwards
    bool unconfined = false;      ///< it runs even with rights that cannot be taken away
    std::vector<char*> program;   ///< and its arguments, a null pointer last
};

/// The program's arguments point into argv. Nothing where the command line is wrong.
std::optional<Order> parseOrder(int argc, char** argv);

/// What --help prints.
extern const char* const orderHelp;

}  // namespace mote::server
