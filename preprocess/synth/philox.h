// SPDX-License-Identifier: GPL-3.0-or-later
//
// Philox4x32-10 (Salmon et al., SC 2011): a random number is a function of a key and a counter, so any
// particle's numbers can be had in any order, on any thread. Pure functions.
#pragma once

#include <array>
#include <cstdint>

namespace mote::prep {

using PhiloxBlock = std::array<std::uint32_t, 4>;

inline PhiloxBlock philox(PhiloxBlock counter, std::uint64_t key) {
    auto low = static_cast<std::uint32_t>(key);
    auto high = static_cast<std::uint32_t>(key >> 32);
    for (int round = 0; round < 10; ++round) {
        const std::uint64_t a = std::uint64_t{0xD2511F53u} * counter[0];
        const std::uint64_t b = std::uint64_t{0xCD9E8D57u} * counter[2];
        counter = {static_cast<std::uint32_t>(b >> 32) ^ counter[1] ^ low, static_cast<std::uint32_t>(b),
                   static_cast<std::uint32_t>(a >> 32) ^ counter[3] ^ high, static_cast<std::uint32_t>(a)};
        low += 0x9E3779B9u;
        high += 0xBB67AE85u;
    }
    return counter;
}

/// The numbers of one particle: uniform in (0, 1), 53 bits, in a fixed order.
class ParticleRandom {
  public:
    ParticleRandom(std::uint64_t seed, std::uint64_t particle) : seed_(seed), particle_(particle) {}

    double next() {
        if (used_ == 2) refill();
        const std::uint64_t bits = (std::uint64_t{block_[2 * used_]} << 32 | block_[2 * used_ + 1]) >> 11;
        ++used_;
        return (static_cast<double>(bits) + 0.5) * 0x1p-53;
    }

  private:
    void refill() {
        block_ = philox({static_cast<std::uint32_t>(particle_), static_cast<std::uint32_t>(particle_ >> 32),
                         draw_++, 0x6D6F7465u},
                        seed_);
        used_ = 0;
    }

    std::uint64_t seed_;
    std::uint64_t particle_;
    std::uint32_t draw_ = 0;
    std::size_t used_ = 2;
    PhiloxBlock block_{};
};

}  // namespace mote::prep
