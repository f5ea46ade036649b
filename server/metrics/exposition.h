// SPDX-License-Identifier: GPL-3.0-or-later
//
// The metrics as text for Prometheus: what was counted, and what is now. Pure, but for a look at this
// process.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "server/metrics/metrics.h"

namespace mote::server {

/// What is now.
struct Gauges {
    std::string version, device;
    std::size_t sessions = 0;
    std::size_t startups = 0;                 ///< connections that have shown no token yet
    std::map<std::string, std::size_t> jobs;  ///< by state
    std::size_t datasets = 0;                 ///< in the catalogue
    std::size_t queries = 0;                  ///< for numbers, on a thread or waiting for one
    std::uint64_t dataBytes = 0;              ///< of datasets, in memory
    std::uint64_t dataLimit = 0;              ///< bytes that they may take
    bool healthy = true;
};

/// In Prometheus' text format, version 0.0.4.
std::string toPrometheus(const Metrics& metrics, const Gauges& gauges);

}  // namespace mote::server
