// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/stipple/packed_moves.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace mote::render {
namespace {

constexpr std::size_t blockPoints = 4096;

// How a move is written after its neighbour's removal: not at all, in one byte a coordinate, or as floats.
constexpr std::uint32_t stays = 0;
constexpr std::uint32_t steps = 1;
constexpr std::uint32_t jumps = 2;

// Moves of a density are alike: four times their root mean square is 127 units, and the few that are longer
// are written as floats.
constexpr float unitsPerDeviation = 127.0F / 4.0F;
// Moves below these are not made; they add to those that follow.
constexpr float leastUnits = 4.0F;

void writeNumber(std::uint64_t number, std::vector<std::uint8_t>& out) {
    for (; number >= 128; number >>= 7) out.push_back(static_cast<std::uint8_t>(number | 128));
    out.push_back(static_cast<std::uint8_t>(number));
}

float greatest(const glm::vec3& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

}  // namespace

PackedMoves::PackedMoves(const storage::StippleHierarchy& hierarchy)
    : points_(static_cast<std::uint32_t>(hierarchy.size())) {
    const auto flat = [](const glm::vec3& v) { return v.z == 0.0F; };
    if (std::all_of(hierarchy.movePosition.begin(), hierarchy.movePosition.end(), flat) &&
        std::all_of(hierarchy.positions.begin(), hierarchy.positions.end(), flat)) {
        dimensions_ = 2;
    }
    findUnits(hierarchy);
    begin_.reserve(hierarchy.size() + 1);
    for (std::size_t point = 0; point <= hierarchy.size(); ++point) {
        if (point % blockPoints == 0) block_.push_back(bytes_.size());
        begin_.push_back(static_cast<std::uint32_t>(bytes_.size() - block_.back()));
        if (point < hierarchy.size()) pack(hierarchy, point);
    }
    bytes_.shrink_to_fit();
}

float PackedMoves::unitAt(std::uint32_t removal) const {
    return unit_[static_cast<std::size_t>(std::bit_width(points_ - removal))];
}

float PackedMoves::error(std::uint32_t left) const {
    return leastUnits * unitAt(points_ - left);
}

void PackedMoves::findUnits(const storage::StippleHierarchy& h) {
    std::array<double, 33> squares{};
    std::array<double, 33> counts{};
    for (std::size_t point = 0; point < h.size(); ++point) {
        auto last = h.positions[point];
        for (auto m = h.movesBegin[point]; m < h.movesBegin[point + 1]; ++m) {
            const auto bits =
                static_cast<std::size_t>(std::bit_width(points_ - h.removal[h.moveNeighbour[m]]));
            const auto step = h.movePosition[m] - last;
            last = h.movePosition[m];
            squares[bits] += step.x * step.x + step.y * step.y + step.z * step.z;
            counts[bits] += dimensions_;
        }
    }
    for (std::size_t bits = 0; bits < unit_.size(); ++bits) {
        if (counts[bits] == 0.0) continue;
        unit_[bits] = static_cast<float>(std::sqrt(squares[bits] / counts[bits])) / unitsPerDeviation;
    }
}

void PackedMoves::pack(const storage::StippleHierarchy& h, std::size_t point) {
    auto at = h.positions[point];
    std::uint64_t next = 0;  // the least removal that may follow
    for (auto m = h.movesBegin[point]; m < h.movesBegin[point + 1]; ++m) {
        const auto removal = h.removal[h.moveNeighbour[m]];
        const auto& goal = h.movePosition[m];
        const float unit = unitAt(removal);
        const float units = unit > 0.0F ? greatest(goal - at) / unit : 0.0F;
        // A comparison with what overflowed is a jump, too.
        const auto kind = units < leastUnits ? stays : units <= 127.0F ? steps : jumps;
        writeNumber((removal - next) << 2 | kind, bytes_);
        next = std::uint64_t{removal} + 1;
        if (kind == steps) {
            for (int d = 0; d < dimensions_; ++d) {
                const auto number = static_cast<std::int8_t>(std::lround((goal[d] - at[d]) / unit));
                bytes_.push_back(static_cast<std::uint8_t>(number));
                at[d] += static_cast<float>(number) * unit;
            }
        } else if (kind == jumps) {
            const auto size = bytes_.size();
            bytes_.resize(size + sizeof(goal));
            std::memcpy(&bytes_[size], &goal, sizeof(goal));
            at = goal;
        }
    }
}

PackedMoves::Walk PackedMoves::walk(std::size_t point, const glm::vec3& first) const {
    Walk walk;
    walk.moves_ = this;
    walk.at_ = bytes_.data() + block_[point / blockPoints] + begin_[point];
    walk.end_ = bytes_.data() + block_[(point + 1) / blockPoints] + begin_[point + 1];
    walk.position_ = first;
    return walk;
}

std::optional<std::uint32_t> PackedMoves::Walk::next() {
    if (at_ == end_) return std::nullopt;
    std::uint64_t number = 0;
    for (int shift = 0;; shift += 7) {
        const std::uint64_t byte = *at_++;
        number |= (byte & 127) << shift;
        if (byte < 128) break;
    }
    kind_ = static_cast<std::uint32_t>(number & 3);
    removal_ += 1 + static_cast<std::uint32_t>(number >> 2);
    return removal_;
}

void PackedMoves::Walk::make() {
    if (kind_ == steps) {
        const float unit = moves_->unitAt(removal_);
        for (int d = 0; d < moves_->dimensions_; ++d) {
            position_[d] += static_cast<float>(static_cast<std::int8_t>(*at_++)) * unit;
        }
    } else if (kind_ == jumps) {
        std::memcpy(&position_, at_, sizeof(position_));
        at_ += sizeof(position_);
    }
}

std::size_t PackedMoves::bytes() const {
    return bytes_.capacity() + block_.capacity() * sizeof(block_[0]) + begin_.capacity() * sizeof(begin_[0]);
}

}  // namespace mote::render
