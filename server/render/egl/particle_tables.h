// SPDX-License-Identifier: GPL-3.0-or-later
//
// ParticleTables: transfer tables of layers of particles, kept as long as their curves are in use. Owned by
// the device.
#pragma once

#include <list>
#include <utility>
#include <vector>

#include "server/render/egl/table_entries.h"
#include "server/render/plan/volume_table.h"

namespace mote::render {

struct ParticleTable {
    VolumeTable table;
    std::vector<TableEntry> entries;

    explicit ParticleTable(const ParticlesStyle& style) : table(style), entries(tableEntries(table)) {}
};

class ParticleTables {
  public:
    /// The table of a style's volume curve and colour map. The reference stays valid for the next 15 calls.
    const ParticleTable& of(const ParticlesStyle& style);

  private:
    using Key = std::pair<Curve, ColorMap>;
    struct Entry {
        Key key;
        ParticleTable made;
    };

    static constexpr std::size_t kept = 16;
    std::list<Entry> entries_;  ///< last used first
};

}  // namespace mote::render
