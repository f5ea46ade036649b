// SPDX-License-Identifier: GPL-3.0-or-later
//
// TableEntry: a transfer table's entry as shaders/matter.glsl reads it. Made in main memory; the upload is
// the frame's.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "server/render/plan/transfer_table.h"

namespace mote::render {

/// The bits of a float: the integral of extinction up to the entry; its slope there; colour; in the upper
/// half the most significant bits of a float, by how much the slope bends, in the lower half how many entries
/// it is to one with extinction.
using TableEntry = std::array<std::uint32_t, 4>;

/// The entries for shaders, as many as TransferTable has.
std::vector<TableEntry> tableEntries(const TransferTable& table);

}  // namespace mote::render
