// SPDX-License-Identifier: GPL-3.0-or-later
//
// What lists of datasets and files share: the row that keys move, and how dates are told. Main thread, within
// a Dear ImGui frame.
#pragma once

#include <cstdint>
#include <string>

namespace mote::client {

/// "2026-11-28 14:05", by this machine's clock; empty if it is not known. `unixMs`: Unix time.
std::string dateOf(std::int64_t unixMs);

/// Moves a marked row by the arrows and by pages, within the list that is drawn, and scrolls to it. `height`:
/// of a row, pixels.
void moveRow(int& row, int count, float height);

}  // namespace mote::client
