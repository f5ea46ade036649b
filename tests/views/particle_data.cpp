// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/views/particle_data.h"

#include <array>

#include "tests/support/beams.h"
#include "tests/support/random.h"

namespace mote::test {
namespace {

using Points = std::vector<WeightedPoint>;

glm::dvec3 anywhere(Random& random) {
    const double x = random.unit(), y = random.unit(), z = random.unit();
    return {x, y, z};
}

Points scattered(Random& random, std::size_t count) {
    Points points;
    for (std::size_t i = 0; i < count; ++i) {
        const glm::dvec3 place = anywhere(random);
        points.push_back({place, random.magnitude(-3, 3)});
    }
    return points;
}

/// On the corners, edges and faces of the box.
Points atTheBorder(Random& random) {
    Points points;
    for (unsigned corner = 0; corner < 8; ++corner)
        points.push_back({{corner & 1U, corner >> 1 & 1U, corner >> 2}, 1.0});
    for (int i = 0; i < 200; ++i) {
        glm::dvec3 place = anywhere(random);
        place[static_cast<int>(random.below(3))] = random.chance(0.5) ? 1.0 : 0.0;
        points.push_back({place, 1.0});
    }
    return points;
}

/// Many in one place: a leaf at the deepest level that holds more than it may.
Points inALump(Random& random) {
    const glm::dvec3 place = anywhere(random);
    Points points(400, {place, 1.0});
    for (const auto& other : scattered(random, 30)) points.push_back(other);
    return points;
}

Points pointsOf(const std::string& form, Random& random, std::uint64_t seed) {
    if (form == "one") return scattered(random, 1);
    if (form == "few") return scattered(random, 2 + random.below(40));
    if (form == "border") return atTheBorder(random);
    if (form == "lump") return inALump(random);
    if (form == "cloud") return evenCloud(1500, seed);
    if (form == "noise") return evenCloud(300, seed);
    if (form == "constant") return evenCloud(100, seed);
    if (form == "beam") return beam({.core = 6000, .halo = 1200, .filaments = 800, .seed = seed});
    if (form != "wide") return {};
    return beam({.core = 2500,
                 .halo = 1500,
                 .filaments = 600,
                 .coreSigma = 0.12,
                 .evenWeights = false,
                 .seed = seed});
}

/// One density everywhere: the scale's least or greatest, between them, or none.
void makeConstant(MemoryStepOptions& options, std::uint32_t number) {
    const std::array<float, 4> densities{1.0F, 3.0F, 16.0F, 0.0F};
    options.volume.assign(std::size_t{1} << (3 * options.volumeLevel), densities[number % 4]);
    options.logDensity = number % 3 == 2 ? LogDensity{3.0, 3.0} : LogDensity{1.0, 16.0};
}

/// No cell like its neighbours; a fifth of them empty.
void makeNoise(MemoryStepOptions& options, Random& random) {
    const std::size_t cells = std::size_t{1} << (3 * options.volumeLevel);
    for (std::size_t i = 0; i < cells; ++i)
        options.volume.push_back(random.chance(0.2) ? 0.0F : static_cast<float>(random.magnitude(-2, 8)));
    options.logDensity = LogDensity{1.0, 128.0};
}

}  // namespace

std::span<const std::string_view> particleForms() {
    static constexpr std::array<std::string_view, 11> forms{
        "empty", "one", "few", "border", "lump", "cloud", "beam", "beam", "wide", "noise", "constant"};
    return forms;
}

std::shared_ptr<const MemoryStep> particleStep(const std::string& form, std::uint32_t number,
                                               std::uint32_t step) {
    const std::uint64_t seed = 100 * std::uint64_t{number} + step + 1;
    Random random(seed, 1);
    MemoryStepOptions options{.leafCapacity = random.oneOf({1U, 8U, 64U, 256U}),
                              .maxLevel = random.oneOf<std::uint8_t>({3, 7, 10, 16}),
                              .volumeLevel = random.oneOf<std::uint8_t>({0, 1, 2, 3, 4, 5, 5, 6}),
                              .seed = seed};
    if (form == "beam" || form == "wide") {
        options.leafCapacity = 64;
        options.maxLevel = 9;
        options.volumeLevel = static_cast<std::uint8_t>(4 + number % 3);
    }
    if (form == "constant") makeConstant(options, number);
    if (form == "noise") options.volumeLevel = std::min<std::uint8_t>(options.volumeLevel, 4);
    if (form == "noise") makeNoise(options, random);
    return MemoryStep::make(pointsOf(form, random, seed), options);
}

}  // namespace mote::test
