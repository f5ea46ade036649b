// SPDX-License-Identifier: GPL-3.0-or-later
//
// SparseWalk: what a SmoothWalk does, where few of a packet's pixels have points in a slab. Each meeting of a
// pixel and a slab adds to the pixel's light what does not depend on the others but for how much they let
// through: so meetings of any pixels and slabs are brought together and made side by side, and then added up,
// pixel by pixel, front to back. Compiled once for each target (Highway's foreach_target), hence without
// #pragma once.
#if defined(MOTE_SPARSE_WALK_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_SPARSE_WALK_INL_H
#undef MOTE_SPARSE_WALK_INL_H
#else
#define MOTE_SPARSE_WALK_INL_H
#endif

#include <bit>

#include "server/render/cpu/composite/smooth_walk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Which of a packet's cells in a slab hold points, a bit each.
HWY_INLINE std::uint32_t heldCells(const PointCell* cells) {
    const Floats d;
    std::uint32_t held = 0;
    for (std::size_t lane = 0; lane < Tile::packetPixels; lane += hn::MaxLanes(d)) {
        V weight, moment;
        hn::LoadInterleaved2(d, &cells[lane].weight, weight, moment);
        std::uint64_t bits = 0;
        hn::StoreMaskBits(d, hn::Gt(weight, hn::Zero(d)), reinterpret_cast<std::uint8_t*>(&bits));
        held |= static_cast<std::uint32_t>(bits) << lane;
    }
    return held;
}

/// Of a packet with points of one layer alone.
class SparseWalk {
  public:
    SparseWalk(const CompositeFrame& frame, const Packet& packet, const TileLattice& lattice,
               const ToldNodes& nodes)
        : frame_(frame), packet_(packet), lattice_(lattice), nodes_(nodes) {
        passed_.fill({1.0F, 0.0F, 0.0F, 0.0F});
        through_.values.fill(1.0F);
    }

    /// Whether a packet is better walked so: it has points of one layer, in few of its pixels in a slab. It
    /// must not depend on how wide vectors are.
    static bool suits(const CompositeFrame& frame, const Packet& packet) {
        constexpr int most = 4;
        if (packet.points.size() != 1) return false;
        int slabs = 0, meetings = 0;
        for (std::uint32_t slab = packet.nextPoints(0); slab < frame.slabs;
             slab = packet.nextPoints(slab + 1)) {
            meetings += std::popcount(heldCells(packet.cells(0, slab)));
            ++slabs;
        }
        return meetings <= most * slabs;
    }

    HWY_INLINE void run() {
        for (std::uint32_t slab = packet_.nextPoints(0); slab < frame_.slabs;
             slab = packet_.nextPoints(slab + 1)) {
            const PointCell* const cells = packet_.cells(0, slab);
            for (std::uint32_t held = heldCells(cells) & ~gone_; held != 0; held &= held - 1) {
                const auto pixel = static_cast<std::uint32_t>(std::countr_zero(held));
                bring(slab, pixel, cells[pixel]);
                if (count_ == Tile::packetPixels) addUp();
            }
        }
        addUp();
    }

    /// Of pixels from `lane` on, at the end.
    HWY_INLINE Light light(std::size_t lane) const {
        const Floats d;
        Light light, passed;
        hn::LoadInterleaved4(d, light_[lane].data(), light.left, light.red, light.green, light.blue);
        hn::LoadInterleaved4(d, passed_[lane].data(), passed.left, passed.red, passed.green, passed.blue);
        const V through = hn::Load(d, through_.data() + lane);
        const Light end = nodes_.at(lattice_.lastRow(), lane);
        light.red = hn::MulAdd(through, hn::Sub(end.red, passed.red), light.red);
        light.green = hn::MulAdd(through, hn::Sub(end.green, passed.green), light.green);
        light.blue = hn::MulAdd(through, hn::Sub(end.blue, passed.blue), light.blue);
        light.left = hn::Mul(through, end.left);
        light.gone();
        return light;
    }

  private:
    using Fours = hn::CappedTag<float, 4>;
    using ToldPixels = std::array<TileLattice::Told, Tile::packetPixels>;

    HWY_INLINE void bring(std::uint32_t slab, std::uint32_t pixel, const PointCell& cell) {
        const std::size_t i = count_++;
        pixel_[i] = pixel;
        weight_[i] = cell.weight;
        moment_[i] = cell.depth;
        nearest_[i] = frame_.depths[slab].nearest;
        thickness_[i] = frame_.depths[slab].thickness;
        for (std::size_t c = 0; c < 3; ++c) color_[c][i] = packet_.pointColors[0][c][pixel];
        nodes_.around(lattice_.row(slab), pixel, front_[i], back_[i]);
    }

    /// What the meetings add, each to its pixel.
    HWY_NOINLINE void addUp() {
        for (std::size_t i = 0; i < count_; i += hn::MaxLanes(Floats())) make(i);
        for (std::size_t i = 0; i < count_; ++i) add(i, pixel_[i]);
        count_ = 0;
    }

    /// Of a vector of meetings: the light of points and of fields up to the border behind them, as if all
    /// came to the slab's front; and what the points let through.
    HWY_INLINE void make(std::size_t first) {
        const Floats d;
        const auto load = [&](const Lanes& lanes) HWY_ATTR { return hn::Load(d, lanes.data() + first); };
        const auto told = [&](const ToldPixels& pixels) HWY_ATTR {
            Light light;
            hn::LoadInterleaved4(d, pixels[first].data(), light.left, light.red, light.green, light.blue);
            light.left = ToldNodes::possible(light.left);
            return light;
        };
        const SpreadPoints points(load(weight_), load(moment_), frame_.points[0], load(nearest_),
                                  load(thickness_));
        const Light front = told(front_), back = told(back_);
        const Light from = between(front, back, points.near), to = between(front, back, points.far);
        Light mixed;
        V passed;
        gatherMixed(points.tau, {load(color_[0]), load(color_[1]), load(color_[2])}, from, to, passed, mixed);
        const auto all = [&](V before, V among, V end, V behind) HWY_ATTR {
            return hn::MulAdd(passed, hn::Sub(behind, end), hn::Add(before, among));
        };
        hn::StoreInterleaved4(passed, all(from.red, mixed.red, to.red, back.red),
                              all(from.green, mixed.green, to.green, back.green),
                              all(from.blue, mixed.blue, to.blue, back.blue), d, front_[first].data());
    }

    HWY_INLINE void add(std::size_t i, std::size_t pixel) {
        const Fours d;
        const float through = through_[pixel];
        for (std::size_t c = 0; c < 4; c += hn::MaxLanes(d)) {
            const auto gained =
                hn::Sub(hn::LoadU(d, front_[i].data() + c), hn::LoadU(d, passed_[pixel].data() + c));
            float* const light = light_[pixel].data() + c;
            hn::StoreU(hn::MulAdd(hn::Set(d, through), gained, hn::LoadU(d, light)), d, light);
        }
        passed_[pixel] = back_[i];
        through_[pixel] = through * front_[i][0];
        if (through_[pixel] * back_[i][0] < Light::least) gone_ |= 1U << pixel;
    }

    // Of each pixel: its light (the first number means nothing), what the fields alone are up to its last
    // meeting, and what its points let through.
    alignas(64) ToldPixels light_{}, passed_;
    Lanes through_;
    // Meetings that are to be added up. `front_` becomes what each adds, and in the place of what is left of
    // light what its points let through.
    Lanes weight_{}, moment_{}, nearest_{}, thickness_{};
    std::array<Lanes, 3> color_{};
    alignas(64) ToldPixels front_{}, back_{};
    std::array<std::uint32_t, Tile::packetPixels> pixel_;
    const CompositeFrame& frame_;
    const Packet& packet_;
    const TileLattice& lattice_;
    const ToldNodes& nodes_;
    std::size_t count_ = 0;
    std::uint32_t gone_ = 0;  // pixels, a bit each, of which no more is seen
};

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
