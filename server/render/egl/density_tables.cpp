// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/density_tables.h"

#include "protocol/scene/most_recent.h"

namespace mote::render {

const DensityTable& DensityTables::of(const TransferFunction& transfer) {
    return mostRecent(
               entries_, kept, [&](const Entry& one) { return one.transfer == transfer; },
               [&] {
                   return Entry{transfer, DensityTable(transfer)};
               })
        .made;
}

}  // namespace mote::render
