// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/composite/composite.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <utility>

#include "server/render/cpu/composite/own_points.h"
#include "server/render/cpu/composite/packet.h"
#include "server/render/cpu/composite/tile_lattice.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/render/cpu/composite/composite.cpp"
#include <hwy/foreach_target.h>
// After foreach_target: these are compiled once for each target.
#include "server/render/cpu/composite/own_walk-inl.h"
#include "server/render/cpu/composite/packet_walk-inl.h"
#include "server/render/cpu/composite/smooth_walk-inl.h"
#include "server/render/cpu/composite/sparse_walk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {

// From linear light to the bytes of a picture, a vector at a time.

/// The sRGB encoding of a linear component, 0 to 255, rounded to the nearest; at most 0.003 of a step off
/// before rounding.
HWY_INLINE WordV encoded(V linear) {
    const Floats d;
    const V x = hn::Min(hn::Max(linear, hn::Zero(d)), hn::Set(d, 1.0F));
    // IEC 61966-2-1 in the fourth root of x, in which the power 1/2.4 is nearly a polynomial: interpolated at
    // the Chebyshev nodes of its range.
    const V root = hn::Sqrt(hn::Sqrt(x));
    V curved = hn::MulAdd(hn::Set(d, -16.0035428F), root, hn::Set(d, 69.5518221F));
    curved = hn::MulAdd(curved, root, hn::Set(d, -142.176691F));
    curved = hn::MulAdd(curved, root, hn::Set(d, 317.274569F));
    curved = hn::MulAdd(curved, root, hn::Set(d, 42.0683701F));
    curved = hn::MulAdd(curved, root, hn::Set(d, -15.7155749F));
    const V straight = hn::Mul(x, hn::Set(d, 255.0F * 12.92F));
    const V value = hn::IfThenElse(hn::Le(x, hn::Set(d, 0.0031308F)), straight, curved);
    return hn::BitCast(Words(), hn::NearestInt(value));
}

/// A half float's bits, rounded to the nearest, ties to even; 0 at least (light that follows from a lattice
/// may be a rounding below) and at most the greatest finite one.
HWY_INLINE WordV halfBits(V x) {
    const Floats d;
    const Words words;
    const V held = hn::Min(hn::Max(x, hn::Zero(d)), hn::Set(d, 65504.0F));
    // Below the least normal half, adding 1/2 leaves the bits where a half has them.
    const V shift = hn::Set(d, 0.5F);
    const WordV small = hn::Sub(hn::BitCast(words, hn::Add(held, shift)), hn::BitCast(words, shift));
    const WordV bits = hn::BitCast(words, held);
    const WordV odd = hn::And(hn::ShiftRight<13>(bits), hn::Set(words, 1U));
    // The exponents' biases are 127 and 15.
    const WordV rebased = hn::Sub(bits, hn::Set(words, 112U << 23));
    const WordV normal = hn::ShiftRight<13>(hn::Add(hn::Add(rebased, hn::Set(words, 0xfffU)), odd));
    const auto tiny = hn::RebindMask(words, hn::Lt(held, hn::Set(d, 0x1p-14F)));
    return hn::IfThenElse(tiny, small, normal);
}

/// Light with what comes through of the background, as words of a picture's pixels: one or two a pixel. A
/// pixel that nothing was in front of has the very bytes of `blank`.
HWY_INLINE void storePixels(const CompositeFrame& frame, const Light& light, std::uint32_t* pixels) {
    const Floats d;
    const Words words;
    const V red = hn::MulAdd(light.left, hn::Set(d, frame.background.x), light.red);
    const V green = hn::MulAdd(light.left, hn::Set(d, frame.background.y), light.green);
    const V blue = hn::MulAdd(light.left, hn::Set(d, frame.background.z), light.blue);
    const auto blank = hn::RebindMask(words, hn::Eq(light.left, hn::Set(d, 1.0F)));
    std::uint32_t blankWords[2];
    hwy::CopyBytes<sizeof(blankWords)>(frame.blank.data(), blankWords);
    const WordV first = hn::Set(words, blankWords[0]);
    if (frame.format == PixelFormat::srgb8) {
        const WordV color = hn::Or(hn::Or(encoded(red), hn::ShiftLeft<8>(encoded(green))),
                                   hn::Or(hn::ShiftLeft<16>(encoded(blue)), hn::Set(words, 0xff000000U)));
        hn::StoreU(hn::IfThenElse(blank, first, color), words, pixels);
        return;
    }
    constexpr std::uint32_t opaque = 0x3c00U << 16;  // 1.0
    const WordV low = hn::Or(halfBits(red), hn::ShiftLeft<16>(halfBits(green)));
    const WordV high = hn::Or(halfBits(blue), hn::Set(words, opaque));
    hn::StoreInterleaved2(hn::IfThenElse(blank, first, low),
                          hn::IfThenElse(blank, hn::Set(words, blankWords[1]), high), words, pixels);
}

/// A walk for each vector of a packet's rays.
template <std::size_t... number>
HWY_INLINE std::array<PacketWalk, sizeof...(number)> walksOf(const CompositeFrame& frame,
                                                             const Packet& packet, PacketSights& sights,
                                                             std::index_sequence<number...>) {
    return {PacketWalk(frame, packet, number * hn::MaxLanes(Floats()), sights)...};
}

/// The same of a packet whose points can be added afterwards. False if they cannot, whatever was stored.
bool compositeOwn(const CompositeFrame& frame, Packet& packet, PacketSights& sights, OwnPoints& room,
                  std::uint32_t* pixels) {
    constexpr std::size_t lanes = hn::MaxLanes(Floats());
    const std::size_t words = bytesPerPixel(frame.format) / sizeof(std::uint32_t);
    if (frame.sections.size() != 1 || !packet.anyPoints) return false;
    packet.enter(frame.sections[0]);
    if (!OwnWalk::suits(frame, packet)) return false;
    sights.clear();
    for (std::size_t lane = 0; lane < Tile::packetPixels; lane += lanes) {
        OwnWalk walk(frame, packet, lane, sights, room);
        if (!walk.run()) return false;
        storePixels(frame, walk.light(), pixels + lane * words);
    }
    return true;
}

/// `pixels`: of the packet, row by row, as words of the picture's format.
void compositePacket(const CompositeFrame& frame, Packet& packet, PacketSights& sights, OwnPoints& room,
                     std::uint32_t* pixels) {
    constexpr std::size_t lanes = hn::MaxLanes(Floats());
    const std::size_t words = bytesPerPixel(frame.format) / sizeof(std::uint32_t);
    if (compositeOwn(frame, packet, sights, room, pixels)) return;
    auto walks = walksOf(frame, packet, sights, std::make_index_sequence<Tile::packetPixels / lanes>());
    for (const auto& section : frame.sections) {
        packet.enter(section);
        sights.clear();
        for (auto& walk : walks) walk.run(section);
    }
    for (std::size_t i = 0; i < walks.size(); ++i)
        storePixels(frame, walks[i].light(), pixels + i * lanes * words);
}

/// What is told of some nodes, as many as a packet has rays or fewer; the last is told for those that miss.
template <std::size_t... number>
HWY_INLINE std::array<ToldBorders, sizeof...(number)> toldOf(std::span<const std::uint32_t> nodes,
                                                             TileLattice& lattice,
                                                             std::index_sequence<number...>) {
    const auto told = [&](std::size_t first) {
        ToldBorders::Rows rows;
        for (std::size_t i = 0; i < rows.size(); ++i)
            rows[i] = &lattice.at(0, nodes[std::min(first + i, nodes.size() - 1)]);
        return ToldBorders(lattice.borders(), rows);
    };
    return {told(number * ToldBorders::rays)...};
}

/// Walks as many nodes as the packet has rays, and tells them.
void walkNodes(const CompositeFrame& frame, Packet& packet, PacketSights& sights,
               std::span<const std::uint32_t> nodes, TileLattice& lattice) {
    constexpr std::size_t lanes = hn::MaxLanes(Floats());
    constexpr auto numbers = std::make_index_sequence<Tile::packetPixels / lanes>();
    auto walks = walksOf(frame, packet, sights, numbers);
    auto told = toldOf(nodes, lattice, numbers);
    for (const auto& section : frame.sections) {
        packet.enter(section);
        sights.clear();
        for (std::size_t i = 0; i * lanes < nodes.size(); ++i) walks[i].run(section, told[i], lattice.end());
    }
}

/// The pixels of a packet whose fields follow from the lattice.
void compositeSmooth(const CompositeFrame& frame, const Packet& packet, const TileLattice& lattice,
                     std::uint32_t* pixels) {
    constexpr std::size_t lanes = hn::MaxLanes(Floats());
    const std::size_t words = bytesPerPixel(frame.format) / sizeof(std::uint32_t);
    const ToldNodes nodes(lattice, packet.number);
    if (packet.anyPoints && SparseWalk::suits(frame, packet)) {
        SparseWalk walk(frame, packet, lattice, nodes);
        walk.run();
        for (std::size_t lane = 0; lane < Tile::packetPixels; lane += lanes)
            storePixels(frame, walk.light(lane), pixels + lane * words);
        return;
    }
    for (std::size_t lane = 0; lane < Tile::packetPixels; lane += lanes)
        storePixels(frame, SmoothWalk(frame, packet, lattice, nodes, lane).run(), pixels + lane * words);
}

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace mote::render {
namespace {

HWY_EXPORT(compositePacket);
HWY_EXPORT(compositeSmooth);
HWY_EXPORT(walkNodes);

/// The rows of a packet's pixels that lie in the picture.
void writePacket(const CompositeFrame& frame, const std::uint8_t* pixels, std::uint32_t x, std::uint32_t y,
                 std::uint8_t* picture) {
    const std::size_t size = bytesPerPixel(frame.format);
    const std::uint32_t columns = std::min(Tile::packetEdge, frame.width - x);
    const std::uint32_t rows = std::min(Tile::packetEdge, frame.height - y);
    for (std::uint32_t row = 0; row < rows; ++row) {
        std::memcpy(picture + (std::size_t{y + row} * frame.width + x) * size,
                    pixels + std::size_t{row} * Tile::packetEdge * size, columns * size);
    }
}

PacketPlaces placesOf(std::uint32_t x, std::uint32_t y) {
    PacketPlaces places;
    for (std::uint32_t i = 0; i < places.size(); ++i) {
        const std::uint32_t column = i % Tile::packetEdge, row = i / Tile::packetEdge;
        places[i] = glm::dvec2(x + column + 0.5, y + row + 0.5);
    }
    return places;
}

/// A tile's pixels, packet by packet.
class TileComposite {
  public:
    TileComposite(const CompositeFrame& frame, Tile tile, std::span<const TileCells> points,
                  const TileDots* dots)
        : frame_(frame),
          tile_(tile),
          points_(points),
          dots_(dots),
          seen_(!frame.reach.of(tile).empty()),
          occupied_(occupiedSlabs(points, dots, frame.slabs)) {
        if (frame.smooth != 0 && seen_ && dots == nullptr) tellLattice();
    }

    /// Of the packet with the pixel (x, y) of the picture for its first; as many as a packet has.
    void draw(std::uint32_t number, std::uint32_t x, std::uint32_t y, std::uint32_t* pixels) {
        packet_.setPoints(frame_, points_, dots_, number, occupied_[number], x, y);
        const bool smooth = lattice_ && lattice_->smooth(number);
        if (!smooth && seen_) packet_.setRays(frame_, placesOf(x, y));
        if (!seen_) packet_.setNoRays();
        if (!packet_.anyPoints && (smooth ? lattice_->blank(number) : !packet_.anyHit)) {
            const std::size_t size = bytesPerPixel(frame_.format);
            auto* const bytes = reinterpret_cast<std::uint8_t*>(pixels);
            for (std::size_t i = 0; i < Tile::packetPixels; ++i)
                std::memcpy(bytes + i * size, frame_.blank.data(), size);
        } else if (smooth) {
            HWY_DYNAMIC_DISPATCH(compositeSmooth)(frame_, packet_, *lattice_, pixels);
        } else {
            HWY_DYNAMIC_DISPATCH(compositePacket)(frame_, packet_, sights_, own_, pixels);
        }
    }

  private:
    void tellLattice() {
        lattice_ = std::make_unique<TileLattice>(frame_, tile_, points_);
        TileLattice& lattice = *lattice_;
        while (!lattice.wanted().empty()) {
            for (auto left = lattice.wanted(); !left.empty();) {
                const auto some = left.first(std::min<std::size_t>(left.size(), Tile::packetPixels));
                packet_.setRays(frame_, lattice.places(some));
                HWY_DYNAMIC_DISPATCH(walkNodes)(frame_, packet_, sights_, some, lattice);
                left = left.subspan(some.size());
            }
            lattice.judge();
        }
    }

    Packet packet_;
    const CompositeFrame& frame_;
    const Tile tile_;
    const std::span<const TileCells> points_;
    const TileDots* const dots_;
    const bool seen_;  // whether fields may show anything
    const std::array<SlabBits, Tile::packets> occupied_;
    std::unique_ptr<TileLattice> lattice_;  // none: each pixel has rays of its own
    PacketSights sights_;
    OwnPoints own_;
};

}  // namespace

void compositeTile(const CompositeFrame& frame, Tile tile, std::span<const TileCells> points,
                   const TileDots* dots, std::uint8_t* picture) {
    constexpr std::uint32_t across = Tile::edge / Tile::packetEdge;
    alignas(64) std::array<std::uint32_t, std::size_t{2} * Tile::packetPixels> words{};
    TileComposite composite(frame, tile, points, dots);
    for (std::uint32_t number = 0; number < Tile::packets; ++number) {
        const std::uint32_t x = tile.column * Tile::edge + number % across * Tile::packetEdge;
        const std::uint32_t y = tile.row * Tile::edge + number / across * Tile::packetEdge;
        if (x >= frame.width || y >= frame.height) continue;
        composite.draw(number, x, y, words.data());
        writePacket(frame, reinterpret_cast<const std::uint8_t*>(words.data()), x, y, picture);
    }
}

}  // namespace mote::render
#endif  // HWY_ONCE
