// SPDX-License-Identifier: GPL-3.0-or-later
//
// DensityTables: transfer tables of layers of particles, kept as long as their curves are in use. Owned by
// the device.
#pragma once

#include <list>
#include <utility>
#include <vector>

#include "server/render/egl/table_entries.h"
#include "server/render/plan/transfer_table.h"

namespace mote::render {

struct DensityTable {
    TransferTable table;
    std::vector<TableEntry> entries;

    explicit DensityTable(const TransferFunction& transfer) : table(transfer), entries(tableEntries(table)) {}
};

class DensityTables {
  public:
    /// The reference stays valid for the next 15 calls.
    const DensityTable& of(const TransferFunction& transfer);

  private:
    struct Entry {
        TransferFunction transfer;
        DensityTable made;
    };

    static constexpr std::size_t kept = 16;
    std::list<Entry> entries_;  ///< last used first
};

}  // namespace mote::render
