// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/hybrid/brick_maker.h"

#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <glm/vector_relational.hpp>

#include "storage/hybrid/normal_table.h"

namespace mote::render {
namespace {

constexpr std::uint32_t edge = GridBricks::edge, samples = GridBricks::samples;

std::size_t placeIn(const glm::uvec3& at) {
    return (std::size_t{at.z} * samples + at.y) * samples + at.x;
}

template <class Visit>
void forEach(std::uint32_t side, const Visit& visit) {
    for (std::uint32_t z = 0; z < side; ++z) {
        for (std::uint32_t y = 0; y < side; ++y) {
            for (std::uint32_t x = 0; x < side; ++x) visit(glm::uvec3(x, y, z));
        }
    }
}

/// A sample's place among those that are the brick's own.
std::size_t ownPlace(const glm::uvec3& at) {
    return (std::size_t{at.z} * edge + at.y) * edge + at.x;
}

/// Bit 4 dz + 2 dy + dx: whether a sample is a corner of cells of the brick (dx, dy, dz) before.
unsigned reachOf(const glm::uvec3& at) {
    const unsigned faces = (at.x == 0 ? 1U : 0U) | (at.y == 0 ? 2U : 0U) | (at.z == 0 ? 4U : 0U);
    unsigned reach = 0;
    for (unsigned back = 0; back < 8; ++back) {
        if ((back & faces) == back) reach |= 1U << back;
    }
    return reach;
}

/// Likewise of any sample with a residual.
unsigned reachOf(BrickResidual residual) {
    unsigned reach = 0;
    forEach(edge, [&](const glm::uvec3& at) {
        if (residual[ownPlace(at)] != 0.0F) reach |= reachOf(at);
    });
    return reach;
}

glm::uvec3 bricksAlong(const glm::uvec3& size) {
    return (size + (edge - 1U)) / edge;
}

}  // namespace

BrickMaker::BrickMaker(const GridField& step, const glm::uvec3& size) : step_(step) {
    bricks_.size = size;
    bricks_.count = bricksAlong(size);
    bricks_.numbers.assign(std::size_t{bricks_.count.x} * bricks_.count.y * bricks_.count.z,
                           GridBricks::none);
    glm::dmat3 toLayer(step.boxToLayer);
    for (int axis = 0; axis < 3; ++axis) {
        toLayer[axis] /= size[axis];
        for (std::uint32_t i = 0; i < size[axis]; ++i) {
            const double place = storage::placeIn(i, size[axis], step.coarse.size[axis]);
            between_[static_cast<std::size_t>(axis)].push_back(
                storage::between(place, step.coarse.size[axis]));
        }
    }
    gradientToLayer_ = glm::mat3(glm::transpose(glm::inverse(toLayer)));
}

Status BrickMaker::claim(const glm::uvec3& brick) {
    std::int32_t& number = bricks_.numbers[bricks_.index(brick)];
    if (number != GridBricks::none) return success();
    if (told_.size() >= GridBricks::most) {
        return Error{ErrorCode::resourceExhausted, "residual",
                     fmt::format("more than {} bricks of {}^3 samples are corrected, too many to draw",
                                 GridBricks::most, edge)};
    }
    number = static_cast<std::int32_t>(told_.size());
    told_.emplace_back();
    bricks_.values.resize(told_.size() * GridBricks::volume);
    if (ownNormals_) bricks_.normals.resize(bricks_.values.size());
    return success();
}

Status BrickMaker::claimReached(const glm::uvec3& brick, unsigned reach) {
    for (unsigned back = 0; back < 8; ++back) {
        const glm::uvec3 before(back & 1U, back >> 1 & 1U, back >> 2);
        if ((reach >> back & 1U) == 0 || brick.x < before.x || brick.y < before.y || brick.z < before.z)
            continue;
        MOTE_RETURN_IF_ERROR(claim(brick - before));
    }
    return success();
}

Status BrickMaker::addPoint(const glm::uvec3& sample, std::uint16_t code, std::uint8_t normal) {
    const glm::uvec3 brick = sample / edge, at = sample % edge;
    ownNormals_ = true;
    MOTE_RETURN_IF_ERROR(claimReached(brick, reachOf(at)));
    const auto number = static_cast<std::size_t>(bricks_.numbers[bricks_.index(brick)]);
    told_[number].set(ownPlace(at));
    bricks_.values[number * GridBricks::volume + placeIn(at)] = code;
    bricks_.normals[number * GridBricks::volume + placeIn(at)] = normal;
    return success();
}

Status BrickMaker::add(const glm::uvec3& brick, BrickResidual residual) {
    const unsigned reach = reachOf(residual);
    MOTE_RETURN_IF_ERROR(claimReached(brick, reach));
    if (reach == 0) return success();
    const auto number = static_cast<std::size_t>(bricks_.numbers[bricks_.index(brick)]);
    told_[number].set();
    const double scale = 65535.0 / (step_.range.high - step_.range.low);
    forEach(edge, [&](const glm::uvec3& at) {
        const glm::uvec3 sample = brick * edge + at;
        if (sample.x >= bricks_.size.x || sample.y >= bricks_.size.y || sample.z >= bricks_.size.z) return;
        const double code = lowAt(sample) + residual[ownPlace(at)] * scale;
        bricks_.values[number * GridBricks::volume + placeIn(at)] =
            static_cast<std::uint16_t>(std::lround(std::clamp(code, 0.0, 65535.0)));
    });
    return success();
}

/// The coarse grid's code at a sample of the error grid.
float BrickMaker::lowAt(const glm::uvec3& sample) const {
    const storage::Between &x = between_[0][sample.x], &y = between_[1][sample.y], &z = between_[2][sample.z];
    const auto along = [&](std::uint32_t row, std::uint32_t sheet) {
        const float one = step_.coarse.values[step_.coarse.index({x.first, row, sheet})];
        const float other = step_.coarse.values[step_.coarse.index({x.second, row, sheet})];
        return one + x.fraction * (other - one);
    };
    const auto across = [&](std::uint32_t sheet) {
        const float one = along(y.first, sheet), other = along(y.second, sheet);
        return one + y.fraction * (other - one);
    };
    const float one = across(z.first), other = across(z.second);
    return one + z.fraction * (other - one);
}

/// The corrected code at a sample; the nearest one's beyond the grid.
float BrickMaker::sampleAt(const glm::ivec3& sample) const {
    const glm::uvec3 inside(glm::clamp(sample, glm::ivec3(0), glm::ivec3(bricks_.size) - 1));
    const std::int32_t number = bricks_.numbers[bricks_.index(inside / edge)];
    if (number == GridBricks::none) return std::round(lowAt(inside));
    return bricks_.values[static_cast<std::size_t>(number) * GridBricks::volume + placeIn(inside % edge)];
}

/// Samples that nothing was told of are the coarse grid's.
void BrickMaker::fill(std::size_t brick) {
    const std::int32_t number = bricks_.numbers[brick];
    if (number == GridBricks::none || told_[static_cast<std::size_t>(number)].all()) return;
    const auto& told = told_[static_cast<std::size_t>(number)];
    const glm::uvec3 first =
        edge * glm::uvec3(brick % bricks_.count.x, brick / bricks_.count.x % bricks_.count.y,
                          brick / bricks_.count.x / bricks_.count.y);
    forEach(edge, [&](const glm::uvec3& at) {
        if (told[ownPlace(at)]) return;
        const glm::uvec3 sample = glm::min(first + at, bricks_.size - 1U);
        bricks_.values[static_cast<std::size_t>(number) * GridBricks::volume + placeIn(at)] =
            static_cast<std::uint16_t>(std::lround(lowAt(sample)));
    });
}

/// Central differences, in layer space, towards greater values.
glm::vec3 BrickMaker::gradient(const Surroundings& around, const glm::uvec3& at) const {
    constexpr std::size_t row = wide, sheet = row * wide;
    const std::size_t here = (at.z + 1) * sheet + (at.y + 1) * row + at.x + 1;
    return gradientToLayer_ * glm::vec3(around[here + 1] - around[here - 1],
                                        around[here + row] - around[here - row],
                                        around[here + sheet] - around[here - sheet]);
}

/// The point's own, else the field's; the nearest sample's beyond the grid.
std::uint8_t BrickMaker::normalAt(const Surroundings& around, const glm::uvec3& sample,
                                  const glm::uvec3& inBrick) const {
    const glm::uvec3 inside = glm::min(sample, bricks_.size - 1U);
    const std::int32_t number = bricks_.numbers[bricks_.index(inside / edge)];
    if (ownNormals_ && number != GridBricks::none) {
        const auto n = static_cast<std::size_t>(number);
        if (told_[n][ownPlace(inside % edge)])
            return bricks_.normals[n * GridBricks::volume + placeIn(inside % edge)];
    }
    static const storage::NormalTable normals;  // made of a million distances
    return normals.code(-gradient(around, inBrick));
}

/// The samples that a brick shares with those behind it, the normals and the range of all.
void BrickMaker::finish(std::size_t brick) {
    if (bricks_.numbers[brick] == GridBricks::none) return;
    const std::size_t begin = static_cast<std::size_t>(bricks_.numbers[brick]) * GridBricks::volume;
    const glm::uvec3 at(brick % bricks_.count.x, brick / bricks_.count.x % bricks_.count.y,
                        brick / bricks_.count.x / bricks_.count.y);
    const auto& told = told_[static_cast<std::size_t>(bricks_.numbers[brick])];
    Surroundings around;
    forEach(wide, [&](const glm::uvec3& place) {
        around[(std::size_t{place.z} * wide + place.y) * wide + place.x] =
            sampleAt(glm::ivec3(edge * at + place) - 1);
    });
    forEach(samples, [&](const glm::uvec3& place) {
        // Only those that no other brick reads: the others are read at the same time.
        if (place.x == edge || place.y == edge || place.z == edge ||
            glm::any(glm::greaterThanEqual(edge * at + place, bricks_.size))) {
            bricks_.values[begin + placeIn(place)] = static_cast<std::uint16_t>(
                around[((std::size_t{place.z} + 1) * wide + place.y + 1) * wide + place.x + 1]);
        }
        // A point's own stays as it is: other bricks may be reading it.
        const bool own =
            glm::all(glm::lessThan(place, glm::uvec3(edge))) && ownNormals_ && told[ownPlace(place)];
        if (!own) bricks_.normals[begin + placeIn(place)] = normalAt(around, edge * at + place, place);
    });
    bricks_.ranges[begin / GridBricks::volume] =
        rangeOf(std::span(bricks_.values).subspan(begin, GridBricks::volume));
}

GridBricks BrickMaker::make() {
    constexpr std::size_t more = 4;  // that can be read
    bricks_.values.resize(told_.size() * GridBricks::volume + more);
    bricks_.values.shrink_to_fit();
    bricks_.normals.resize(bricks_.values.size());
    bricks_.normals.shrink_to_fit();
    bricks_.ranges.resize(told_.size());
    tbb::parallel_for(std::size_t{0}, bricks_.numbers.size(), [this](std::size_t i) { fill(i); });
    tbb::parallel_for(std::size_t{0}, bricks_.numbers.size(), [this](std::size_t i) { finish(i); });
    return std::move(bricks_);
}

}  // namespace mote::render
