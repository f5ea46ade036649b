// SPDX-License-Identifier: GPL-3.0-or-later
//
// DotCursor: where a vector of rays stands among the dots of its pixels, front to back. Compiled once for
// each target (Highway's foreach_target), hence without #pragma once.
#if defined(MOTE_DOT_CURSOR_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_DOT_CURSOR_INL_H
#undef MOTE_DOT_CURSOR_INL_H
#else
#define MOTE_DOT_CURSOR_INL_H
#endif

#include "server/render/cpu/light-inl.h"
#include "server/render/cpu/packet.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

class DotCursor {
  public:
    /// `lane`: of the packet's pixels, the vector's first.
    HWY_INLINE DotCursor(const Packet& packet, std::size_t lane) {
        hn::Store(hn::Set(Floats(), beyond), Floats(), next_.data());
        if (packet.dots == nullptr) return;
        for (std::size_t i = 0; i < hn::Lanes(Floats()); ++i) {
            left_[i] =
                packet.dots->of(packet.number * Tile::packetPixels + static_cast<std::uint32_t>(lane + i));
            if (!left_[i].empty()) next_[i] = left_[i].front().place;
        }
    }

    /// The depth of the next dot, where it lies before `end`.
    HWY_INLINE V nextCut(V end) const { return hn::Min(hn::Load(Floats(), next_.data()), end); }

    /// Gathers the dots up to a depth.
    HWY_NOINLINE void pass(V to, Light& light) {
        const Floats d;
        if (hn::AllFalse(d, hn::Le(hn::Load(d, next_.data()), to))) return;
        Lanes depth, red{}, green{}, blue{}, passed;
        hn::Store(to, d, depth.data());
        for (std::size_t i = 0; i < hn::Lanes(d); ++i) {
            passed[i] = 1.0F;
            while (next_[i] <= depth[i]) {
                const DotHit& hit = left_[i].front();
                const float share = passed[i] * hit.opacity;
                red[i] += share * hit.color.x;
                green[i] += share * hit.color.y;
                blue[i] += share * hit.color.z;
                passed[i] -= share;
                left_[i] = left_[i].subspan(1);
                next_[i] = left_[i].empty() ? beyond : left_[i].front().place;
            }
        }
        light.red = hn::MulAdd(light.left, hn::Load(d, red.data()), light.red);
        light.green = hn::MulAdd(light.left, hn::Load(d, green.data()), light.green);
        light.blue = hn::MulAdd(light.left, hn::Load(d, blue.data()), light.blue);
        light.left = hn::Mul(light.left, hn::Load(d, passed.data()));
    }

  private:
    static constexpr float beyond = 1e30F;  // of a pixel without further dots, slabs

    Lanes next_;  // depth of each ray's next dot
    std::array<std::span<const DotHit>, Tile::packetPixels> left_{};
};

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
