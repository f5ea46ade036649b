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

/// The slab behind which points hide everything in all pixels of a tile; all slabs where they do not.
std::uint32_t hiddenFrom(const CompositeFrame& frame, std::span<const TileCells> points) {
    // exp(-10.5) is half of what is left where rays end.
    constexpr float opaque = 10.5F;
    std::uint64_t any = 0;
    for (const auto& layer : points) {
        for (std::uint32_t i = 0; i < layer.slabs(); ++i) any |= layer.occupied(i);
    }
    std::uint64_t open = ~std::uint64_t{0};
    if (any != open) return frame.slabs;
    constexpr std::size_t pairs = Tile::packetPixels / 2;
    std::array<std::array<Four, pairs>, Tile::packets> hidden{};
    for (std::uint32_t slab = 0; slab < frame.slabs; ++slab) {
        const double far = static_cast<double>(frame.depths[slab].nearest) + frame.depths[slab].thickness;
        for (std::size_t l = 0; l < points.size(); ++l) {
            const std::uint32_t own = slab - points[l].firstSlab();  // wraps where the layer begins later
            if (own >= points[l].slabs()) continue;
            const FramePointLook& look = frame.points[l];
            const Four tau = Four{} + (look.byDepth ? static_cast<float>(look.tau / (far * far)) : look.tau);
            for (std::uint64_t left = points[l].occupied(own) & open; left != 0; left &= left - 1) {
                const auto packet = static_cast<std::size_t>(std::countr_zero(left));
                const PointCell* const cells = points[l].slab(own) + packet * Tile::packetPixels;
                auto isOpen = Four{} > Four{};
                for (std::size_t i = 0; i < pairs; ++i) {
                    Four two;  // weight and depth of two cells
                    std::memcpy(&two, cells + 2 * i, sizeof(two));
                    hidden[packet][i] += tau * two;
                    isOpen |= hidden[packet][i] < Four{} + opaque;
                }
                if ((isOpen[0] | isOpen[2]) == 0) open &= ~(std::uint64_t{1} << packet);
            }
        }
        if (open == 0) return slab + 1;
    }
    return frame.slabs;
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
    std::vector<std::uint8_t> occupied(frame.slabs, 0);
    for (const auto& layer : points) {
        for (std::uint32_t i = 0; i < layer.slabs(); ++i)
            if (layer.occupied(i) != 0) occupied[layer.firstSlab() + i] = 1;
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
        if (!before && !behind) occupiedRows_.push_back(rows_[slab]);
    }
    addBorder(frame.slabs);
    rowCount_ = borders_.size();
    borders_.push_back(std::numeric_limits<float>::max());
    told_ = std::make_unique_for_overwrite<Told[]>(rowCount_ * nodes);
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
    for (const std::uint32_t node : wanted_) thin_[node] = !refused_[node] && thinAt(node);
    std::vector<Square> refused;
    for (const auto& square : squares_) {
        const std::uint32_t agreed = quadrantsAgreeing(square.x, square.y, step_);
        for (std::uint32_t quadrant = 0; quadrant < 4; ++quadrant) {
            const Square part{square.x + quadrant % 2 * 2 * step_, square.y + quadrant / 2 * 2 * step_};
            if (!thin(part)) continue;
            if ((agreed >> quadrant & 1U) != 0) {
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

/// Whether so little of a node's light is lost between the borders of slabs with points that it is lost
/// evenly there.
bool TileLattice::thinAt(std::uint32_t node) const {
    const Told* const told = &at(0, node);
    const auto allowed = [](float front) { return mostLost * front + leastLost; };
    // Light only becomes less: what holds of all of it holds of each part.
    const float end = told[lastRow()][0];
    if (told[0][0] - end <= allowed(end)) return true;
    return std::none_of(occupiedRows_.begin(), occupiedRows_.end(), [&](std::uint32_t row) {
        const float front = told[row][0];
        return front - told[row + 1][0] > allowed(front);
    });
}

/// Whether all nodes of a part are.
bool TileLattice::thin(const Square& part) const {
    for (std::uint32_t k = 0; k < 9; ++k) {
        if (!thin_[latticeNode(part.x + k % 3 * step_, part.y + k / 3 * step_)]) return false;
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
/// are to be.
bool TileLattice::agrees(std::uint32_t node, const Following& following) const {
    return following.count == 3 ? agreesBy<3>(node, following) : agreesBy<9>(node, following);
}

template <std::size_t count>
bool TileLattice::agreesBy(std::uint32_t node, const Following& following) const {
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
    constexpr std::size_t together = 8;  // rows, of which all are looked at before any is refused
    for (std::size_t row = 0; row < rowCount_;) {
        auto tooFar = Four{} > Four{};
        for (const std::size_t last = std::min(row + together, rowCount_); row < last; ++row) {
            Four followed{};
            for (std::size_t k = 0; k < count; ++k) followed += weights[k] * four(others[k][row]);
            const Four here = four(own[row]), off = here - followed, most = mayBeOff + slope * here;
            tooFar |= (off > most) | (-off > most);
        }
        if ((tooFar[0] | tooFar[1] | tooFar[2] | tooFar[3]) != 0) return false;
    }
    return true;
}

/// By quarter of a square of 5 x 5 nodes, a bit each: whether all of its nodes follow from every second one
/// of the square.
std::uint32_t TileLattice::quadrantsAgreeing(std::uint32_t x, std::uint32_t y, std::uint32_t step) const {
    std::uint32_t agreed = 15;
    for (std::uint32_t k = 0; k < squareNodes; ++k) {
        const std::uint32_t i = k % (squareSteps + 1), j = k / (squareSteps + 1);
        std::uint32_t touched = 0;
        for (std::uint32_t q = 0; q < 4; ++q) {
            const std::uint32_t left = q % 2 * 2, top = q / 2 * 2;
            if (i >= left && i <= left + 2 && j >= top && j <= top + 2) touched |= 1U << q;
        }
        if ((i % 2 == 0 && j % 2 == 0) || (agreed & touched) == 0) continue;
        if (!agrees(squareNode(x, y, step, k), Following(x, y, step, i, j))) agreed &= ~touched;
    }
    return agreed;
}

bool TileLattice::blank(std::uint32_t packet) const {
    const Around nodes = around(packet);
    for (std::uint32_t k = 0; k < 9; ++k) {
        if (at(lastRow(), nodes.first + nodes.step * latticeNode(k % 3, k / 3))[0] != 1.0F) return false;
    }
    return true;
}

}  // namespace mote::render
