// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/particle_exchange.h"

#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cstring>
#include <numeric>

namespace mote::prep {
namespace {

/// Alone, more, so that reading rarely waits; with others, fewer, whose messages find memory that is warm.
std::size_t blocksPerRound(const Communicator& ranks) {
    return ranks.size() == 1 ? 16 : 4;
}

/// What stands before a batch's share in a message.
struct Header {
    std::uint64_t particles;
};

template <class T>
void append(Bytes& bytes, std::span<const T> values) {
    const auto raw = std::as_bytes(values);
    bytes.insert(bytes.end(), raw.begin(), raw.end());
    bytes.resize((bytes.size() + 7) / 8 * 8);  // what follows stands at a multiple of 8
}

/// Takes values off the front of a message that append() wrote.
template <class T>
std::span<const T> take(std::span<const std::byte>& bytes, std::size_t count) {
    const std::span values(reinterpret_cast<const T*>(bytes.data()), count);
    bytes = bytes.subspan((count * sizeof(T) + 7) / 8 * 8);
    return values;
}

}  // namespace

ParticleExchange::ParticleExchange(const CellPlan& plan, Communicator& ranks, bool withWeights)
    : plan_(plan), ranks_(ranks), withWeights_(withWeights) {
    assignRanges();
}

/// Ranges in turn, so that each rank has about as many particles.
void ParticleExchange::assignRanges() {
    const auto size = static_cast<std::size_t>(ranks_.size());
    firstRange_.push_back(0);
    for (std::size_t rank = 1; rank < size; ++rank) {
        const std::uint64_t wanted = plan_.particles() * rank / size;
        std::size_t range = firstRange_.back();
        while (range < plan_.ranges.size() && plan_.ranges[range].begin < wanted) ++range;
        firstRange_.push_back(range);
    }
    firstRange_.push_back(plan_.ranges.size());
}

/// Within a range, particles of earlier ranks come first: they are of earlier rows.
Status ParticleExchange::findPlaces(const std::vector<std::uint32_t>& cells) {
    std::vector<std::uint32_t> mine(plan_.ranges.size());
    for (std::size_t cell = 0; cell < cells.size(); ++cell) mine[plan_.rangeOfCell[cell]] += cells[cell];
    MOTE_ASSIGN_OR_RETURN(const auto counts, shareValues<std::uint32_t>(ranks_, mine));
    const auto rank = static_cast<std::size_t>(ranks_.rank());
    next_.assign(counts.size(), std::vector<std::uint64_t>(rangesOf(rank)));
    for (std::size_t i = 0; i < rangesOf(rank); ++i) {
        const std::size_t range = firstRange_[rank] + i;
        std::uint64_t at = plan_.ranges[range].begin - plan_.ranges[firstRange_[rank]].begin;
        for (std::size_t from = 0; from < counts.size(); ++from) {
            next_[from][i] = at;
            at += counts[from][range];
        }
    }
    return success();
}

Result<std::size_t> ParticleExchange::findRounds(const StepReader& reader) {
    const std::size_t together = blocksPerRound(ranks_);
    const std::uint64_t mine = (reader.blockCount() + together - 1) / together;
    MOTE_ASSIGN_OR_RETURN(const auto all, shareValues<std::uint64_t>(ranks_, std::span(&mine, 1)));
    std::uint64_t most = 0;
    for (const auto& one : all) most = std::max(most, one.front());
    return static_cast<std::size_t>(most);
}

Status ParticleExchange::run(StepReader& reader, const std::array<Range, 3>& bounds,
                             const std::vector<std::uint32_t>& cells, SortedParticles& store) {
    MOTE_RETURN_IF_ERROR(findPlaces(cells));
    MOTE_ASSIGN_OR_RETURN(const auto rounds, findRounds(reader));
    tbb::enumerable_thread_specific<QuantizedBlock> blocks;
    const std::size_t together = blocksPerRound(ranks_);
    std::vector<Batch> batches(together);
    for (std::size_t round = 0; round < rounds; ++round) {
        const std::size_t begin = std::min(reader.blockCount(), round * together);
        const std::size_t end = std::min(reader.blockCount(), begin + together);
        batches.resize(end - begin);
        const auto read = reader.forEach(begin, end, [&](const ParticleBlock& block, std::size_t i) {
            auto& quantized = blocks.local();
            quantize(block, bounds, quantized);
            sortByRange(quantized, batches[i - begin]);
        });
        MOTE_RETURN_IF_ERROR(agree(ranks_, read));
        MOTE_RETURN_IF_ERROR(agree(ranks_, deliver(batches, store)));
    }
    return success();
}

void ParticleExchange::sortByRange(const QuantizedBlock& block, Batch& batch) const {
    batch.counts.assign(plan_.ranges.size(), 0);
    const auto rangeOf = [&](const Particle& particle) {
        return plan_.rangeOfCell[gridCellOf(particle, plan_.gridLevel)];
    };
    for (const auto& particle : block.particles) ++batch.counts[rangeOf(particle)];
    std::vector<std::uint32_t> next(batch.counts.size());
    std::exclusive_scan(batch.counts.begin(), batch.counts.end(), next.begin(), 0U);
    batch.particles.resize(block.particles.size());
    batch.weights.resize(withWeights_ ? block.particles.size() : 0);
    for (std::size_t i = 0; i < block.particles.size(); ++i) {
        const auto to = next[rangeOf(block.particles[i])]++;
        batch.particles[to] = block.particles[i];
        if (withWeights_) batch.weights[to] = block.weight[i];
    }
}

ParticleExchange::Share ParticleExchange::shareOf(const Batch& batch, std::size_t rank) const {
    const auto first = batch.counts.begin() + static_cast<std::ptrdiff_t>(firstRange_[rank]);
    const auto last = batch.counts.begin() + static_cast<std::ptrdiff_t>(firstRange_[rank + 1]);
    const std::size_t begin = std::accumulate(batch.counts.begin(), first, std::size_t{0});
    const std::size_t count = std::accumulate(first, last, std::size_t{0});
    return {{first, last},
            std::span(batch.particles).subspan(begin, count),
            withWeights_ ? std::span(batch.weights).subspan(begin, count) : std::span<const double>()};
}

Status ParticleExchange::deliver(const std::vector<Batch>& batches, SortedParticles& store) {
    if (ranks_.size() == 1) {
        std::vector<Share> shares;
        for (const auto& batch : batches) shares.push_back(shareOf(batch, 0));
        return place(0, shares, store);
    }
    std::vector<Bytes> outgoing;
    for (std::size_t rank = 0; rank + 1 < firstRange_.size(); ++rank) outgoing.push_back(pack(batches, rank));
    MOTE_ASSIGN_OR_RETURN(const auto incoming, ranks_.exchange(std::move(outgoing)));
    for (std::size_t from = 0; from < incoming.size(); ++from) {
        MOTE_RETURN_IF_ERROR(place(from, unpack(incoming[from]), store));
    }
    return success();
}

Status ParticleExchange::place(std::size_t from, const std::vector<Share>& shares, SortedParticles& store) {
    const std::size_t ranges = next_[from].size();
    std::vector<std::uint64_t> at;
    for (const auto& share : shares) {
        for (std::size_t range = 0; range < ranges; ++range) {
            at.push_back(next_[from][range]);
            next_[from][range] += share.counts[range];
        }
    }
    std::vector<Status> written(shares.size(), success());
    tbb::parallel_for(std::size_t{0}, shares.size(), [&](std::size_t i) {
        std::size_t begin = 0;
        for (std::size_t range = 0; range < ranges && written[i].ok(); ++range) {
            const std::size_t count = shares[i].counts[range];
            const std::uint64_t to = at[i * ranges + range];
            written[i] = store.particles.write(to, shares[i].particles.subspan(begin, count));
            if (withWeights_ && written[i].ok()) {
                written[i] = store.weights.write(to, shares[i].weights.subspan(begin, count));
            }
            begin += count;
        }
    });
    for (const auto& status : written) MOTE_RETURN_IF_ERROR(status);
    return success();
}

Bytes ParticleExchange::pack(const std::vector<Batch>& batches, std::size_t rank) const {
    Bytes bytes;
    std::size_t size = 0;
    for (const auto& batch : batches) {
        const auto share = shareOf(batch, rank);
        size += sizeof(Header) + share.counts.size_bytes() + share.particles.size_bytes() +
                share.weights.size_bytes() + 8;
    }
    bytes.reserve(size);
    for (const auto& batch : batches) {
        const auto share = shareOf(batch, rank);
        const Header header{share.particles.size()};
        append(bytes, std::span(&header, 1));
        append(bytes, share.counts);
        append(bytes, share.particles);
        append(bytes, share.weights);
    }
    return bytes;
}

std::vector<ParticleExchange::Share> ParticleExchange::unpack(const Bytes& bytes) const {
    std::vector<Share> shares;
    std::span<const std::byte> rest(bytes);
    while (!rest.empty()) {
        const auto count = take<Header>(rest, 1).front().particles;
        auto& share = shares.emplace_back();
        share.counts = take<std::uint32_t>(rest, rangesOf(static_cast<std::size_t>(ranks_.rank())));
        share.particles = take<Particle>(rest, count);
        if (withWeights_) share.weights = take<double>(rest, count);
    }
    return shares;
}

}  // namespace mote::prep
