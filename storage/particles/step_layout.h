// SPDX-License-Identifier: GPL-3.0-or-later
//
// The arrays of a step file: their names, types, order and content, shared by reader and writer.
// docs/FORMAT.md. Values.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "storage/particles/particle_step.h"

namespace mote::storage {

/// Index of an array in stepArrays.
enum class StepArray : std::size_t {
    octreeLevel,
    octreeMorton,
    octreeFirstChild,
    octreeChildCount,
    octreeCount,
    octreeDensity,
    octreeMinDensity,
    leafNode,
    leafPointBegin,
    leafPointCount,
    leafDensity,
    pointPosition,
    pointRow,
    volumeDensity,
    // Absent, both of them, in files of earlier writers.
    previewPoint,
    previewThreshold,
};

struct StepArrayLayout {
    const char* name;       ///< the dataset's path in the HDF5 file
    std::string_view type;  ///< as in the digest
};

inline constexpr std::array<StepArrayLayout, 16> stepArrays{{
    {"/octree/level", "u8"},
    {"/octree/morton", "u64"},
    {"/octree/first_child", "u32"},
    {"/octree/child_count", "u8"},
    {"/octree/count", "u64"},
    {"/octree/density", "f32"},
    {"/octree/min_density", "f32"},
    {"/leaves/node", "u32"},
    {"/leaves/point_begin", "u64"},
    {"/leaves/point_count", "u32"},
    {"/leaves/density", "f32"},
    {"/points/position", "u16"},
    {"/points/row", "u64"},
    {"/volume/density", "f32"},
    {"/preview/point", "u16"},
    {"/preview/threshold", "f32"},
}};

inline constexpr std::array<const char*, 5> stepGroups{"/octree", "/leaves", "/points", "/volume",
                                                       "/preview"};

/// What a step file says of itself beside its arrays.
struct StepAttributes {
    std::array<std::string, 3> axes;
    std::array<double, 3> boundsMin{};  ///< in the axes' units
    std::array<double, 3> boundsMax{};
    double totalWeight = 0.0;  ///< of the particles in leaves
};

/// How much a step file holds.
struct StepShape {
    std::uint64_t nodes = 0;
    std::uint64_t leaves = 0;
    std::uint64_t points = 0;
    std::uint64_t previewPoints = 0;
    std::uint32_t volumeSize = 0;

    /// The extents of an array, slowest first.
    std::vector<std::uint64_t> of(StepArray which) const;
};

/// What a step file is to hold, as views of arrays that the job owns.
struct StepContent : StepAttributes {
    OctreeNodes nodes;
    Leaves leaves;
    std::span<const PackedPosition> positions;  ///< in the order of the leaves
    std::span<const std::uint64_t> rows;        ///< as many
    std::span<const float> volume;              ///< volumeSize^3, x fastest
    std::uint32_t volumeSize = 0;
    std::span<const PreviewPoint> previewPoints;
    std::span<const float> previewThreshold;  ///< one for each Preview::blockPoints of them, or a part
};

}  // namespace mote::storage
