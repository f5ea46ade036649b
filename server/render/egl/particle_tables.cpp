// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/particle_tables.h"

#include <algorithm>

namespace mote::render {

const ParticleTable& ParticleTables::of(const ParticlesStyle& style) {
    Key key(style.volumeOpacity, style.colorMap);
    const auto found =
        std::find_if(entries_.begin(), entries_.end(), [&](const Entry& one) { return one.key == key; });
    if (found != entries_.end()) {
        entries_.splice(entries_.begin(), entries_, found);
        return entries_.front().made;
    }
    entries_.push_front({std::move(key), ParticleTable(style)});
    if (entries_.size() > kept) entries_.pop_back();
    return entries_.front().made;
}

}  // namespace mote::render
