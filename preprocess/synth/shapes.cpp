// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/synth/shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <string>

#include "preprocess/draft_file.h"
#include "preprocess/synth/philox.h"

namespace mote::prep {
namespace {

static_assert(std::endian::native == std::endian::little);

/// An ellipsoid of one tissue; places and radii from -1 to 1, x to the left, y to the back, z up.
struct Organ {
    glm::dvec3 middle, radii;
    double units;  ///< Hounsfield's
};

/// In the order in which they take each other's place.
constexpr std::array organs{
    Organ{{0.0, 0.0, 0.0}, {0.92, 0.62, 1.6}, -90.0},      // fat
    Organ{{0.0, 0.0, 0.0}, {0.86, 0.56, 1.5}, 45.0},       // muscle
    Organ{{0.42, -0.04, 0.25}, {0.3, 0.4, 0.62}, -820.0},  // lungs
    Organ{{-0.42, -0.04, 0.25}, {0.3, 0.4, 0.62}, -820.0},
    Organ{{0.1, -0.12, 0.1}, {0.24, 0.22, 0.26}, 110.0},   // heart
    Organ{{-0.3, -0.05, -0.55}, {0.46, 0.4, 0.28}, 75.0},  // liver
    Organ{{0.4, 0.1, -0.55}, {0.22, 0.2, 0.16}, 60.0},     // spleen
    Organ{{0.0, 0.3, 0.0}, {0.05, 0.05, 1.6}, 190.0},      // aorta
};

/// 0 outside to 1 inside of a distance, over one voxel.
double insideOf(double distance, double voxel) {
    return std::clamp(0.5 - distance / voxel, 0.0, 1.0);
}

/// About how far a place is from an ellipsoid; less than 0 inside.
double distanceTo(const Organ& organ, const glm::dvec3& at) {
    const glm::dvec3 scaled = (at - organ.middle) / organ.radii;
    const double length = glm::length(scaled);
    return (length - 1.0) * std::min({organ.radii.x, organ.radii.y, organ.radii.z});
}

/// Of vertebrae one above the other, and ribs around the chest.
double distanceToBone(const glm::dvec3& at) {
    constexpr double vertebra = 0.16, rib = 0.18;  // from one to the next
    const double level = at.z - vertebra * std::round(at.z / vertebra);
    const glm::dvec3 spine = {at.x, at.y - 0.42, 0.0};
    const double body = std::max(glm::length(spine) - 0.115, std::abs(level) - 0.4 * vertebra);
    const double process =
        std::max({std::abs(at.x) - 0.025, at.y - 0.56, 0.42 - at.y, std::abs(level) - 0.03});
    const double angle = std::atan2(at.y, at.x);
    const double drop = 0.22 * (0.5 - angle / std::numbers::pi);  // ribs lean forward and down
    const double high = at.z + drop, own = high - rib * std::round(high / rib);
    const glm::dvec3 wall = {at.x / 0.8, at.y / 0.5, 0.0};
    const double shell = (glm::length(wall) - 1.0) * 0.5;
    double ribs = std::hypot(shell, own) - 0.03;
    if (std::abs(at.z - 0.25) > 0.66) ribs = 1.0;
    return std::min({body, process, ribs});
}

/// -1 to 1, a sum of evenly spread numbers, by the voxel's number.
double noise(std::uint64_t seed, std::uint64_t number) {
    double sum = 0.0;
    for (const auto one :
         philox({static_cast<std::uint32_t>(number), static_cast<std::uint32_t>(number >> 32)}, seed))
        sum += one * 0x1p-32 - 0.5;
    return 0.5 * sum;
}

double unitsAt(const glm::dvec3& at, double voxel) {
    double units = -1000.0;
    for (const auto& organ : organs) units += (organ.units - units) * insideOf(distanceTo(organ, at), voxel);
    return units + (600.0 - units) * insideOf(distanceToBone(at), voxel);
}

Status writeText(const std::filesystem::path& output, const std::string& text) {
    MOTE_ASSIGN_OR_RETURN(auto draft, DraftFile::create(output));
    MOTE_RETURN_IF_ERROR(draft.reserve(text.size()));
    std::ofstream file(draft.path(), std::ios::binary);
    file.write(text.data(), static_cast<std::streamsize>(text.size()));
    file.close();
    if (!file) return Error{ErrorCode::resourceExhausted, output.string(), "cannot be written to its end"};
    return draft.publish();
}

/// Appends a tube about a closed way, as rings of vertices and the faces between them.
template <class Way>
void addTube(const Way& way, int along, int around, double thick, int& vertices, std::string& obj) {
    const auto number = [&](int j, int i) { return vertices + 1 + (j % along) * around + i % around; };
    const double turn = 2.0 * std::numbers::pi;
    for (int j = 0; j < along; ++j) {
        const double t = turn * j / along, step = 1e-4;
        const glm::dvec3 at = way(t);
        const glm::dvec3 ahead = glm::normalize(way(t + step) - way(t - step));
        const glm::dvec3 across = glm::normalize(glm::cross(ahead, glm::dvec3(0.0, 1.0, 0.0)));
        const glm::dvec3 up = glm::cross(across, ahead);
        for (int i = 0; i < around; ++i) {
            const double angle = turn * i / around;
            const glm::dvec3 place = at + thick * (std::cos(angle) * across + std::sin(angle) * up);
            obj += fmt::format("v {:.6f} {:.6f} {:.6f}\n", place.x, place.y, place.z);
        }
    }
    for (int j = 0; j < along; ++j) {
        for (int i = 0; i < around; ++i) {
            obj += fmt::format("f {} {} {} {}\n", number(j, i), number(j, i + 1), number(j + 1, i + 1),
                               number(j + 1, i));
        }
    }
    vertices += along * around;
}

}  // namespace

Status writePhantom(std::uint32_t voxels, std::uint64_t seed, const std::filesystem::path& output) {
    const double spacing = 400.0 / voxels, voxel = 2.0 / voxels;
    std::string text = fmt::format(
        "NRRD0004\ntype: int16\ndimension: 3\nsizes: {0} {0} {0}\nspace: left-posterior-superior\n"
        "space directions: ({1},0,0) (0,{1},0) (0,0,{1})\nspace origin: (-200,-200,-200)\n"
        "space units: \"mm\" \"mm\" \"mm\"\nendian: little\nencoding: raw\n\n",
        voxels, spacing);
    text.reserve(text.size() + 2 * std::size_t{voxels} * voxels * voxels);
    std::uint64_t number = 0;
    for (std::uint32_t k = 0; k < voxels; ++k) {
        for (std::uint32_t j = 0; j < voxels; ++j) {
            for (std::uint32_t i = 0; i < voxels; ++i) {
                const glm::dvec3 at = (glm::dvec3(i, j, k) + 0.5) * voxel - 1.0;
                const double units = unitsAt(at, voxel) + 16.0 * noise(seed, number++);
                const auto value = static_cast<std::int16_t>(std::lround(units));
                text.append({static_cast<char>(value & 0xff), static_cast<char>(value >> 8)});
            }
        }
    }
    return writeText(output, text);
}

Status writeCoil(const std::filesystem::path& output) {
    constexpr int turns = 14;
    std::string obj = "# a coil: a ring, and wire that is wound about it\n";
    int vertices = 0;
    addTube([](double t) { return glm::dvec3(std::cos(t), 0.0, std::sin(t)); }, 180, 48, 0.24, vertices, obj);
    const auto wire = [](double t) {
        const double out = 1.0 + 0.31 * std::cos(turns * t);
        return glm::dvec3(out * std::cos(t), 0.31 * std::sin(turns * t), out * std::sin(t));
    };
    addTube(wire, 1400, 16, 0.05, vertices, obj);
    return writeText(output, obj);
}

}  // namespace mote::prep
