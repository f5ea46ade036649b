// SPDX-License-Identifier: GPL-3.0-or-later
//
// DicomHeader: what a DICOM file says of its pictures (PS3.3), and nothing of whom they show: elements that
// are not listed in dicom_tags.cpp are stepped over. Parsed from bytes that nobody vouches for. A value.
//
// What Siemens' scanners write into a private element of their own (its form "SV10") of pictures that are
// mosaics: all slices of a volume in one picture, row by row. Pure; from bytes that nobody vouches for.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/volume/byte_stream.h"
#include "protocol/base/error.h"

namespace mote::prep {

struct DicomMosaic {
    std::uint32_t tiles = 0;  ///< slices, at least 1
    glm::dvec3 normal{0.0};   ///< from each to the next one, of unit length, LPS
};

/// None if the bytes are something else, or do not say both.
std::optional<DicomMosaic> siemensMosaic(std::string_view bytes);

/// What may tell pictures at one place apart.
enum class DicomMark : std::uint8_t {
    segment,
    temporal,
    acquisition,
    frameTime,
    trigger,
    echo,
    diffusion,
    kind,
    clock
};
constexpr std::size_t dicomMarks = 9;

/// Of one picture: of all of a file, or of one of its frames.
struct DicomFrame {
    std::optional<glm::dvec3> position;                 ///< of the first pixel's centre, mm, LPS
    std::optional<std::array<double, 6>> orientation;   ///< directions of rows and of columns
    std::optional<std::array<double, 2>> pixelSpacing;  ///< between rows, between columns, mm
    std::optional<double> between, thickness;           ///< of slices, mm
    std::optional<double> slope, intercept;
    std::array<std::optional<double>, dicomMarks> marks;

    std::optional<double>& mark(DicomMark which) { return marks[static_cast<std::size_t>(which)]; }
};

struct DicomHeader {
    enum class Pixels : std::uint8_t { none, integers, floats, doubles };

    std::string syntax, sopInstance, series, modality, photometric;
    std::string valueUnit;  ///< "HU"; "" if the file does not say
    std::optional<double> seriesNumber, instance, sliceLocation;
    std::uint32_t rows = 0, columns = 0, frameCount = 1;
    std::uint32_t samples = 1, allocated = 0, stored = 0, highBit = 0;
    bool isSigned = false, planar = false, bigEndian = false;
    bool mosaic = false, lossy = false, hasTable = false, looseSpacing = false, saysUnit = false;
    DicomMosaic tiles;                 ///< of a mosaic whose slices are known; else of none
    bool otherFrames = false;          ///< frames are no slices: times, views
    std::vector<double> frameOffsets;  ///< mm along the normal, of a dose's frames
    DicomFrame common;
    std::vector<DicomFrame> frames;  ///< of functional groups: one a frame, or none

    Pixels pixels = Pixels::none;
    bool encapsulated = false;     ///< in fragments, as compressed pictures are
    std::uint64_t deflatedAt = 0;  ///< of the file, where all that follows is deflated; 0: nowhere
    std::uint64_t pixelsAt = 0;    ///< of their first byte; if the file is deflated, in what comes out
    std::uint64_t pixelBytes = 0;  ///< if they are not in fragments

    /// How many slices of a mosaic lie side by side, in as many rows; else 1.
    std::uint32_t tilesAcross() const;
    /// The columns of one slice.
    std::uint32_t sliceColumns() const { return columns / tilesAcross(); }
    std::uint32_t sliceRows() const { return rows / tilesAcross(); }

    /// How many bytes of a file's beginning begins() needs.
    static constexpr std::size_t headBytes = 132;
    static bool begins(std::string_view bytes);
    /// Errors, at the file's name and byte: corrupt, resourceExhausted (more than VolumeShape::maxDimension
    /// frames), those of `file`.
    static Result<DicomHeader> parse(ByteStreamPtr file);
};

/// The normal of a picture's plane, at right angles to its rows and columns.
glm::dvec3 normalOf(const std::array<double, 6>& orientation);

/// What follows a file's head: the file itself, or what comes out of it. Errors: those of inflatedStream.
Result<ByteStreamPtr> dicomData(const DicomHeader& header, ByteStreamPtr file);

}  // namespace mote::prep
