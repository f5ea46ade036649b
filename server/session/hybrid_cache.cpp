// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/session/hybrid_cache.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/render/hybrid/hybrid_load.h"

namespace mote::server {

Result<HybridCache::Step> HybridCache::step(const storage::Catalogue::Entry& entry, std::uint32_t index,
                                            HybridRepresentation representation) {
    const auto& manifest = *entry.manifest;
    if (manifest.kind() != "hybrid") {
        return Error{ErrorCode::invalidArgument, "dataset",
                     "\"" + entry.name + "\" is of kind \"" + manifest.kind() + "\", not a hybrid volume"};
    }
    const auto parts = render::hybridParts(manifest.hybrid(), representation);
    if (!parts.ok()) return parts.error();
    const auto found = std::find_if(kept_.begin(), kept_.end(), [&](const Kept& kept) {
        return kept.manifest == entry.manifest && kept.index == index && kept.representation == *parts;
    });
    if (found != kept_.end()) {
        kept_.splice(kept_.begin(), kept_, found);
        return kept_.front().step;
    }
    const auto expected = render::hybridBytes(manifest.hybrid(), index, *parts);
    MOTE_RETURN_IF_ERROR(makeRoom(expected));
    auto loaded = render::loadHybrid(entry.directory, manifest, index, *parts);
    memory_.giveBack(expected);
    if (!loaded.ok()) return loaded.error();
    MOTE_RETURN_IF_ERROR(makeRoom((*loaded)->bytes()));
    kept_.push_front({entry.manifest, index, *parts, *loaded, (*loaded)->bytes()});
    if (kept_.size() > mostSteps) dropLast();
    return kept_.front().step;
}

Status HybridCache::makeRoom(std::uint64_t bytes) {
    while (!memory_.take(bytes)) {
        if (kept_.empty()) {
            return Error{
                ErrorCode::resourceExhausted, "dataset",
                fmt::format("its step takes {} MiB, more than the server has for data", bytes >> 20)};
        }
        dropLast();
    }
    return success();
}

void HybridCache::dropLast() {
    memory_.giveBack(kept_.back().bytes);
    kept_.pop_back();
}

}  // namespace mote::server
