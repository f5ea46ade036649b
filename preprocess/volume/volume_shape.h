// SPDX-License-Identifier: GPL-3.0-or-later
//
// VolumeShape: how many voxels a volume has, where they lie, and what their values are. A value, free of
// threads.
//
// ScalarType: how a file stores one value of a volume, and how its bytes become floats. Pure.
//
// VolumeParts: several volumes in one file (times, frames), or several values for each voxel (components,
// channels), and which of them is read. Values and pure functions.
//
// The space in which a file says where voxels lie, and how it is brought to that of a scene, so that a
// patient lies at one place whatever the format. Pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/base/error.h"

namespace mote::prep {

enum class ScalarType : std::uint8_t { u8, i8, u16, i16, u32, i32, f32, f64, u64, i64, f16 };

/// "u8", "i8", ...: in options, manifests and messages.
std::string_view name(ScalarType type);
std::optional<ScalarType> scalarType(std::string_view name);
std::size_t bytesOf(ScalarType type);  ///< 1, 2, 4 or 8

/// The stored numbers of a file: value = slope * number + intercept.
struct SampleFormat {
    ScalarType type = ScalarType::u8;
    bool bigEndian = false;
    double slope = 1.0, intercept = 0.0;  ///< finite
};

/// `bytes` holds values.size() numbers. If slope and intercept are 1 and 0, each value is the number
/// rounded to the nearest float; else it is computed in double and rounded once.
void decodeSamples(std::span<const char> bytes, const SampleFormat& format, std::span<float> values);
/// The first of the numbers, of integers of 32 and 64 bits, that a float (with a slope: a double) is not.
/// Those of 64 bits are read if that is none; those of 32 are rounded.
std::optional<std::string> inexactNumber(std::span<const char> bytes, const SampleFormat& format);

struct VolumeShape {
    static constexpr std::uint32_t maxDimension = 1u << 16;

    std::uint32_t nx = 0, ny = 0, nz = 0;  ///< voxels, 1 to maxDimension each
    ScalarType type = ScalarType::u8;      ///< as the file stores a value, before slope and intercept
    double valueStep = 0.0;  ///< of integers with a slope: between neighbouring values; 0: not known
    /// The map from voxel indices (the centre of the first voxel is 0, 0, 0) to the file's own world;
    /// invertible.
    glm::dmat4 indexToWorld{1.0};
    std::string worldUnit;  ///< of a length in the world: "mm"; "" if the file does not say
    std::string valueUnit;  ///< of a value: "HU"; "" if the file does not say
    /// The frame of the file's world as NRRD names it, "left-posterior-superior" or "3d-left-handed"; ""
    /// if the file does not say.
    std::string space;
    std::string worldSpace = {};          ///< of indexToWorld: "ras" or "lps"; "": the file's own
    std::optional<double> time = {};      ///< of the volume, s, if the file says it
    std::vector<std::string> notes = {};  ///< what was assumed or left out, a sentence each

    std::uint64_t voxelsOfSlice() const { return std::uint64_t{nx} * ny; }
    std::uint64_t voxels() const { return voxelsOfSlice() * nz; }
};

/// Sets nx, ny and nz. Errors, at `where`: corrupt (a dimension of 0), resourceExhausted (more than
/// maxDimension).
Status setDimensions(VolumeShape& shape, std::uint64_t nx, std::uint64_t ny, std::uint64_t nz,
                     const std::string& where);

/// Three axes (one voxel's step along each) and the first voxel's centre, in world units. Errors, at `where`:
/// corrupt (numbers that are not finite; axes without length or in one plane).
Status setPlacement(VolumeShape& shape, const glm::dmat3& axes, const glm::dvec3& origin,
                    const std::string& where);

/// `text` if it may be a unit: at most 16 printable characters; else "".
std::string unitText(std::string_view text);

/// Text of a file as it may stand in a message: what is not printable ASCII becomes '?'.
std::string printableText(std::string_view text);

struct VolumeParts {
    std::uint64_t volumes = 1;                ///< one after the other
    std::uint64_t components = 1;             ///< of a voxel, one beside the other
    std::uint64_t volume = 0, component = 0;  ///< those that are read, from 0

    std::uint64_t count() const { return volumes * components; }
};

/// `parts` with what `field` asks for: "3", the volume of that number (of a file with one volume, the
/// component), ":2", a component, "3:2" both. Errors, at `where`: unsupported (there are several and none was
/// asked for: a sentence that lists them), notFound (no such number), invalidArgument (`field` is no number),
/// resourceExhausted (more than can be counted).
Result<VolumeParts> chooseParts(std::string_view field, VolumeParts parts, const std::string& where);

/// The fields of all volumes, if `field` leaves open which; else `field` alone.
std::vector<std::string> fieldsOfSeries(const std::string& field, const VolumeParts& parts);

/// NRRD's name of a space in its long form, "left-posterior-superior" of "LPS" or "LPST"; others in lower
/// case, without the time.
std::string longSpace(std::string_view name);

/// Turns `shape`, whose space is the file's, to `wanted`: "ras" (the default, ""), "lps" or "file". A space
/// that is not a patient's stays, but for a left-handed one, whose mirror image would be seen: its z is
/// turned round, with a note. Errors: invalidArgument (another word).
Status bringTo(std::string_view wanted, VolumeShape& shape);

}  // namespace mote::prep
