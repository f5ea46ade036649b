// SPDX-License-Identifier: GPL-3.0-or-later
//
// The arrays of a step file: their names, types and order, shared by reader and writer. docs/FORMAT.md.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

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

}  // namespace mote::storage
