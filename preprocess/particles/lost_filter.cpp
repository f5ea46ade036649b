// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/lost_filter.h"

#include <fmt/format.h>

namespace mote::prep {

Result<LostParticles> parseLostParticles(const std::string& text) {
    if (text.empty() || text == "without") return LostParticles::without;
    if (text == "with") return LostParticles::with;
    if (text == "only") return LostParticles::only;
    return invalid("lost", fmt::format("\"{}\" is none of without, with and only", text.substr(0, 40)));
}

LostParticles lostParticlesOf(const ParticleSource& source, const proto::ParticlesJob& job) {
    const auto settled = source.lostParticles();
    const auto parsed = parseLostParticles(settled.empty() ? job.lost() : settled);
    return parsed.ok() ? *parsed : LostParticles::without;
}

Status LostFilter::read(std::size_t step, std::uint64_t begin, std::size_t count,
                        const std::vector<Column>& wanted, ParticleChunk& chunk) {
    MOTE_RETURN_IF_ERROR(source_->read(step, begin, count, wanted, chunk));
    if (choice_ == LostParticles::without) return success();
    chunk.lost.resize(chunk.size, 0);
    for (auto& lost : chunk.lost) lost = takesPart(choice_, lost != 0) ? 0 : 1;
    return success();
}

}  // namespace mote::prep
