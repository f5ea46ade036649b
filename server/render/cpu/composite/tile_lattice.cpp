// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/composite/tile_lattice.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "server/render/cpu/composite/field_reach.h"

namespace mote::render {
namespace {

// What a value between nodes may be off, in linear light: less than a 255th of what is seen as it is encoded
// (sRGB), which is steeper where it is darker. Light that is left counts by its own share, since points
// behind are seen by it.
constexpr float darkError = 3e-4F, lightError = 0.011F, leftError = 0.009F;
// What is off falls with the square of how far nodes lie apart where a field's slope changes at once, with
// the cube where it is smooth: of nodes twice as far it is four to eight times as large.
constexpr float allowedOfTwice = 6.0F;

// What of light may be lost in a slab with points, as a share of what comes to it and at all: were it lost
// evenly by optical depth, an eighth of the share's square is wrong.
constexpr float mostLost = 0.25F, leastLost = 1e-3F;

/// What is told, as one vector of any processor.
using Four = float __attribute__((vector_size(sizeof(TileLattice::Told))));

Four four(const TileLattice::Told& told) {
    return std::bit_cast<Four>(told);
}

constexpr std::uint32_t squareSteps = 4;  // from side to side of a square that is judged
constexpr std::uint32_t squareNodes = (squareSteps + 1) * (squareSteps + 1);
constexpr std::uint32_t packetsAcross = Tile::edge / Tile::packetEdge;
constexpr std::uint32_t packetSteps = Tile::packetEdge / TileLattice::apart;

constexpr std::uint32_t latticeNode(std::uint32_t x, std::uint32_t y) {
    return y * TileLattice::across + x;
}

/// Of a square of 5 x 5 nodes, `step` apart.
constexpr std::uint32_t squareNode(std::uint32_t x, std::uint32_t y, std::uint32_t step, std::uint32_t k) {
    return latticeNode(x + k % (squareSteps + 1) * step, y + k / (squareSteps + 1) * step);
}

/// The weights of what stands at 0, 2 and 4 for what is at a place from 0 to 4: a parabola.
constexpr std::array<std::array<float, 3>, squareSteps + 1> parabolaWeights{{{1.0F, 0.0F, 0.0F},
                                                                             {0.375F, 0.75F, -0.125F},
                                                                             {0.0F, 1.0F, 0.0F},
                                                                             {-0.125F, 0.75F, 0.375F},
                                                                             {0.0F, 0.0F, 1.0F}}};

/// The slab behind which points hide everything in all pixels of a packet; all slabs where they do not.
std::uint32_t hiddenFrom(const CompositeFrame& frame, std::span<const TileCells> points, std::size_t packet) {
    // exp(-10.5) is half of what is left where rays end.
    constexpr float opaque = 10.5F;
    std::array<Four, Tile::packetPixels / 2> hidden{};
    for (std::uint32_t slab = 0; slab < frame.slabs; ++slab) {
        for (std::size_t l = 0; l < points.size(); ++l) {
            const std::uint32_t own = slab - points[l].firstSlab();  // wraps where the layer begins later
            if (own >= points[l].slabs() || (points[l].occupied(own) >> packet & 1U) == 0) continue;
            const FramePointLook& look = frame.points[l];
            const double far = static_cast<double>(frame.depths[slab].nearest) + frame.depths[slab].thickness;
            const Four tau = Four{} + (look.byDepth ? static_cast<float>(look.tau / (far * far)) : look.tau);
            const PointCell* const cells = points[l].slab(own) + packet * Tile::packetPixels;
            auto isOpen = Four{} > Four{};
            for (std::size_t i = 0; i < hidden.size(); ++i) {
                Four two;  // weight and depth of two cells
                std::memcpy(&two, cells + 2 * i, sizeof(two));
                hidden[i] += tau * two;
                isOpen |= hidden[i] < Four{} + opaque;
            }
            if ((isOpen[0] | isOpen[2]) == 0) return slab + 1;
        }
    }
    return frame.slabs;
}

/// The same of a tile. One packet tells where they do not: the others are not looked at.
std::uint32_t hiddenFrom(const CompositeFrame& frame, std::span<const TileCells> points) {
    std::uint64_t any = 0;
    for (const auto& layer : points) {
        for (std::uint32_t i = 0; i < layer.slabs(); ++i) any |= layer.occupied(i);
    }
    if (any != ~std::uint64_t{0}) return frame.slabs;
    std::uint32_t end = 0;
    for (std::size_t packet = 0; packet < Tile::packets && end < frame.slabs; ++packet)
        end = std::max(end, hiddenFrom(frame, points, packet));
    return end;
}

}  // namespace

/// How the value of a node follows from every second one of its square.
struct TileLattice::Following {
    std::array<std::uint32_t, 9> nodes;
    std::array<float, 9> weight;
    std::size_t count = 0;

    /// Node (i, j) of the square with the first node (x, y), whose nodes are `step` apart.
    Following(std::uint32_t x, std::uint32_t y, std::uint32_t step, std::uint32_t i, std::uint32_t j) {
        for (std::uint32_t k = 0; k < 9; ++k) {
            const float share = parabolaWeights[i][k % 3] * parabolaWeights[j][k / 3];
            if (share == 0.0F) continue;
            nodes[count] = latticeNode(x + 2 * step * (k % 3), y + 2 * step * (k / 3));
            weight[count++] = share;
        }
    }
};

TileLattice::TileLattice(const CompositeFrame& frame, Tile tile, std::span<const TileCells> points)
    : tile_(tile), end_(hiddenFrom(frame, points)), rows_(frame.slabs), step_(frame.smooth) {
    std::vector<std::uint64_t> occupied(frame.slabs, 0);
    for (const auto& layer : points) {
        for (std::uint32_t i = 0; i < layer.slabs(); ++i)
            occupied[layer.firstSlab() + i] |= layer.occupied(i);
    }
    FieldReach::Slabs reach = frame.reach.of(tile);
    reach.end = std::min(reach.end, end_);
    reach.first = std::min(reach.first, reach.end);
    for (std::uint32_t slab = 0; slab < frame.slabs; ++slab) {
        if (occupied[slab] == 0) continue;
        // Before the fields all slabs are like one, and so are those behind.
        const bool before = slab < reach.first, behind = slab >= reach.end;
        rows_[slab] = addBorder(before ? 0 : behind ? reach.end : slab);
        if (!behind) addBorder(before ? reach.first : slab + 1);
        if (occupied_.empty() || occupied_.back().row != rows_[slab]) occupied_.push_back({rows_[slab], 0});
        occupied_.back().packets |= occupied[slab];
    }
    addBorder(frame.slabs);
    rowCount_ = borders_.size();
    borders_.push_back(std::numeric_limits<float>::max());
    told_ = std::make_unique_for_overwrite<Told[]>(borders_.size() * nodes);
    const std::uint32_t edge = squareSteps * step_;
    for (std::uint32_t y = 0; y + edge < across; y += edge) {
        for (std::uint32_t x = 0; x + edge < across; x += edge) squares_.push_back({x, y});
    }
    wantNodes();
}

/// Returns its row. Only the last two may be there already.
std::uint32_t TileLattice::addBorder(std::uint32_t slab) {
    const auto border = static_cast<float>(slab);
    const auto last = static_cast<std::uint32_t>(borders_.size());
    if (last > 1 && borders_[last - 2] == border) return last - 2;
    if (last > 0 && borders_[last - 1] == border) return last - 1;
    borders_.push_back(border);
    return last;
}

PacketPlaces TileLattice::places(std::span<const std::uint32_t> some) const {
    PacketPlaces places;
    for (std::size_t i = 0; i < places.size(); ++i) {
        const std::uint32_t node = some[std::min(i, some.size() - 1)];
        places[i] = glm::dvec2(tile_.column * Tile::edge + node % across * apart,
                               tile_.row * Tile::edge + node / across * apart);
    }
    return places;
}

void TileLattice::wantNodes() {
    wanted_.clear();
    for (const auto& square : squares_) {
        for (std::uint32_t k = 0; k < squareNodes; ++k) {
            const std::uint32_t node = squareNode(square.x, square.y, step_, k);
            if (!std::exchange(known_[node], true)) wanted_.push_back(node);
        }
    }
}

void TileLattice::judge() {
    std::vector<Square> refused;
    for (const auto& square : squares_) {
        for (std::uint32_t quadrant = 0; quadrant < 4; ++quadrant) {
            const Square part{square.x + quadrant % 2 * 2 * step_, square.y + quadrant / 2 * 2 * step_};
            const std::vector<std::uint32_t> rows = rowsOf(part);
            if (!thin(part, rows)) continue;
            if (agrees(square, quadrant, rows)) {
                agree(part);
            } else {
                refused.push_back(part);
            }
        }
    }
    step_ /= 2;
    squares_ = step_ > 0 ? std::move(refused) : std::vector<Square>();
    wantNodes();
}

/// Of the borders before slabs with points in some packet of a part.
std::vector<std::uint32_t> TileLattice::rowsOf(const Square& part) const {
    const std::uint32_t side = 2 * step_ / packetSteps;
    const std::uint32_t first = part.y / packetSteps * packetsAcross + part.x / packetSteps;
    std::uint64_t packets = 0;
    for (std::uint32_t j = 0; j < side; ++j)
        packets |= ((std::uint64_t{1} << side) - 1) << (first + j * packetsAcross);
    std::vector<std::uint32_t> rows;
    rows.reserve(occupied_.size());
    for (const auto& slab : occupied_)
        if ((slab.packets & packets) != 0) rows.push_back(slab.row);
    return rows;
}

/// Whether so little of a node's light is lost in slabs with points that it is lost evenly there.
bool TileLattice::thinAt(std::uint32_t node, std::span<const std::uint32_t> rows) const {
    const Told* const told = &at(0, node);
    const auto allowed = [](float front) { return mostLost * front + leastLost; };
    return std::all_of(rows.begin(), rows.end(), [&](std::uint32_t row) {
        const float front = told[row][0];
        return front - told[row + 1][0] <= allowed(front);
    });
}

/// Whether it is so at all nodes of a part.
bool TileLattice::thin(const Square& part, std::span<const std::uint32_t> rows) const {
    for (std::uint32_t k = 0; k < 9; ++k) {
        if (!thinAt(latticeNode(part.x + k % 3 * step_, part.y + k / 3 * step_), rows)) return false;
    }
    return true;
}

/// The packets of a quadrant follow from its nodes.
void TileLattice::agree(const Square& part) {
    const std::uint32_t packets = 2 * step_ / packetSteps;
    for (std::uint32_t j = 0; j < packets; ++j) {
        for (std::uint32_t i = 0; i < packets; ++i)
            steps_[(part.y / packetSteps + j) * packetsAcross + part.x / packetSteps + i] =
                static_cast<std::uint8_t>(step_);
    }
}

TileLattice::Around TileLattice::around(std::uint32_t packet) const {
    const std::uint32_t step = steps_[packet], edge = 2 * step;
    const std::uint32_t x = packet % packetsAcross * packetSteps, y = packet / packetsAcross * packetSteps;
    return {latticeNode(x / edge * edge, y / edge * edge), step,
            glm::vec2(x % edge, y % edge) / static_cast<float>(step),
            1.0F / static_cast<float>(step * apart)};
}

/// Whether a node is what follows from others, as nearly as is allowed of those twice as far apart as they
/// are to be: at the end, and at the borders of slabs with points. `rows`: of those before these slabs.
template <std::size_t count>
bool TileLattice::agreesBy(std::uint32_t node, const Following& following,
                           std::span<const std::uint32_t> rows) const {
    const Told& end = at(lastRow(), node);
    Told allowed;
    for (std::size_t i = 0; i < end.size(); ++i)
        allowed[i] = allowedOfTwice * (darkError + (i == 0 ? 0.0F : lightError * end[i]));
    const Four mayBeOff = four(allowed), slope{allowedOfTwice * leftError, 0.0F, 0.0F, 0.0F};
    std::array<const Told*, count> others;
    std::array<Four, count> weights;
    for (std::size_t k = 0; k < count; ++k) {
        others[k] = &at(0, following.nodes[k]);
        weights[k] = Four{} + following.weight[k];
    }
    const Told* const own = &at(0, node);
    const auto near = [&](std::size_t row) {
        Four followed{};
        for (std::size_t k = 0; k < count; ++k) followed += weights[k] * four(others[k][row]);
        const Four here = four(own[row]), off = here - followed, most = mayBeOff + slope * here;
        const auto right = (off <= most) & (-off <= most);  // not of what is no number
        return (right[0] & right[1] & right[2] & right[3]) != 0;
    };
    return near(lastRow()) && std::all_of(rows.begin(), rows.end(),
                                          [&](std::uint32_t row) { return near(row) && near(row + 1); });
}

/// Whether all nodes of a quadrant of a square of 5 x 5 of them follow from every second one of the square.
bool TileLattice::agrees(const Square& square, std::uint32_t quadrant,
                         std::span<const std::uint32_t> rows) const {
    for (std::uint32_t k = 0; k < 9; ++k) {
        const std::uint32_t i = quadrant % 2 * 2 + k % 3, j = quadrant / 2 * 2 + k / 3;
        if (i % 2 == 0 && j % 2 == 0) continue;
        const std::uint32_t node = squareNode(square.x, square.y, step_, j * (squareSteps + 1) + i);
        const Following following(square.x, square.y, step_, i, j);
        if (!(following.count == 3 ? agreesBy<3>(node, following, rows) : agreesBy<9>(node, following, rows)))
            return false;
    }
    return true;
}

bool TileLattice::blank(std::uint32_t packet) const {
    const Around nodes = around(packet);
    for (std::uint32_t k = 0; k < 9; ++k) {
        if (at(lastRow(), nodes.first + nodes.step * latticeNode(k % 3, k / 3))[0] != 1.0F) return false;
    }
    return true;
}

}  // namespace mote::render
