// SPDX-License-Identifier: GPL-3.0-or-later
//
// ToldNodes: what the fields of a packet's pixels are by the nodes of a TileLattice around it, at any border.
// Compiled once for each target (Highway's foreach_target), hence without #pragma once.
#if defined(MOTE_TOLD_NODES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_TOLD_NODES_INL_H
#undef MOTE_TOLD_NODES_INL_H
#else
#define MOTE_TOLD_NODES_INL_H
#endif

#include "server/render/cpu/composite/light-inl.h"
#include "server/render/cpu/composite/packet.h"
#include "server/render/cpu/composite/tile_lattice.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

class ToldNodes {
  public:
    HWY_INLINE ToldNodes(const TileLattice& lattice, std::uint32_t packet) {
        const Floats d;
        const TileLattice::Around around = lattice.around(packet);
        for (std::size_t lane = 0; lane < Tile::packetPixels; lane += hn::MaxLanes(d)) {
            Lanes x, y;
            for (std::uint32_t i = 0; i < Tile::packetPixels; ++i) {
                const std::uint32_t column = i % Tile::packetEdge, row = i / Tile::packetEdge;
                x[i] = around.corner.x + (static_cast<float>(column) + 0.5F) * around.pixel;
                y[i] = around.corner.y + (static_cast<float>(row) + 0.5F) * around.pixel;
            }
            const std::array<V, 3> columns = parabola(hn::LoadU(d, x.data() + lane));
            const std::array<V, 3> rows = parabola(hn::LoadU(d, y.data() + lane));
            for (std::uint32_t k = 0; k < 9; ++k)
                hn::Store(hn::Mul(columns[k % 3], rows[k / 3]), d, weight_[k].data() + lane);
        }
        for (std::uint32_t k = 0; k < 9; ++k)
            nodes_[k] = &lattice.at(0, around.first + (k / 3 * TileLattice::across + k % 3) * around.step);
    }

    /// What the fields give off and let through up to a border, of pixels from `lane` on.
    HWY_INLINE Light at(std::size_t row, std::size_t lane) const {
        const Floats d;
        Light light;
        light.left = hn::Zero(d);
        for (std::size_t k = 0; k < 9; ++k) {
            const TileLattice::Told& node = nodes_[k][row];
            const V weight = hn::Load(d, weight_[k].data() + lane);
            light.left = hn::MulAdd(weight, hn::Set(d, node[0]), light.left);
            light.red = hn::MulAdd(weight, hn::Set(d, node[1]), light.red);
            light.green = hn::MulAdd(weight, hn::Set(d, node[2]), light.green);
            light.blue = hn::MulAdd(weight, hn::Set(d, node[3]), light.blue);
        }
        light.left = possible(light.left);
        return light;
    }

    /// The same of one pixel at two borders that follow each other; what is left may be more or less than can
    /// be (possible()).
    HWY_INLINE void around(std::size_t row, std::size_t pixel, TileLattice::Told& front,
                           TileLattice::Told& back) const {
        const hn::CappedTag<float, 8> d;
        alignas(32) std::array<TileLattice::Told, 2> both;
        for (std::size_t i = 0; i < 8; i += hn::MaxLanes(d)) {
            // Three sums that do not wait for each other, in registers.
            const auto told = [&](std::size_t k) HWY_ATTR { return hn::LoadU(d, nodes_[k][row].data() + i); };
            const auto weight = [&](std::size_t k) HWY_ATTR { return hn::Set(d, weight_[k][pixel]); };
            const auto three = [&](std::size_t k) HWY_ATTR {
                return hn::MulAdd(weight(k + 2), told(k + 2),
                                  hn::MulAdd(weight(k + 1), told(k + 1), hn::Mul(weight(k), told(k))));
            };
            const auto sum = hn::Add(hn::Add(three(0), three(3)), three(6));
            hn::Store(sum, d, reinterpret_cast<float*>(both.data()) + i);
        }
        front = both[0];
        back = both[1];
    }

    /// A parabola may lead beyond what can be.
    HWY_INLINE static V possible(V left) {
        const Floats d;
        return hn::Min(hn::Max(left, hn::Zero(d)), hn::Set(d, 1.0F));
    }

  private:
    /// The weights of what stands at 0, 1 and 2.
    HWY_INLINE static std::array<V, 3> parabola(V x) {
        const Floats d;
        const V half = hn::Set(d, 0.5F), one = hn::Set(d, 1.0F), two = hn::Set(d, 2.0F);
        return {hn::Mul(hn::Mul(hn::Sub(x, one), hn::Sub(x, two)), half), hn::Mul(x, hn::Sub(two, x)),
                hn::Mul(hn::Mul(x, hn::Sub(x, one)), half)};
    }

    std::array<Lanes, 9> weight_;                    // of the nodes around
    std::array<const TileLattice::Told*, 9> nodes_;  // of each the first of its rows
};

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
