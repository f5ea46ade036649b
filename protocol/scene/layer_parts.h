// SPDX-License-Identifier: GPL-3.0-or-later
//
// What layers carry besides their style: of particles a colour by a column, a selection, a highlight, paths;
// of what has steps another step that they are on their way to. Each is read, written and shown to visitors
// here, so that view.cpp knows none of them. Pure functions.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/color_map.h"
#include "protocol/scene/field_visitor.h"
#include "protocol/scene/particles_style.h"
#include "protocol/scene/selection.h"
#include "protocol/scene/transfer_function.h"

namespace mote {

struct Layer;

// Points and volume that take their colour from a column or derived quantity (docs/PICTURE.md, "Colour by a
// column"). A parsed message is valid in itself (whether there is such a column, the dataset knows).

/// Fills every default. Errors: no name, a range that does not ascend, a map or a word that is not known.
Result<proto::ColorBy> parseColorBy(proto::ColorBy message);

/// Of a parsed one: what its colour map goes over; none: 1% to 99% of the weight of all steps.
std::optional<ValueRange> colorRangeOf(const proto::ColorBy& colorBy);
ColorMap colorMapOf(const proto::ColorBy& colorBy);
/// Whether a pixel has the colour of its nearest point's value, not of the mean of all: as it says, or where
/// points are opaque.
bool colorsOfNearest(const proto::ColorBy& colorBy, const ParticlesStyle& style);

// Highlight: which points of a layer are drawn over the others, and how (docs/PICTURE.md, "Highlights"). A
// value; a parsed one is valid in itself.
struct Highlight {
    Selection selection;
    glm::dvec3 color{0.0};            ///< linear RGB
    std::optional<double> pointSize;  ///< pixels; absent: the layer's
    double opacity = 0.0;             ///< of one point, at most ParticlesStyle::opacityLimit

    bool operator==(const Highlight&) const = default;
};

/// Fills every default. Errors: of the selection, a number out of range.
Result<Highlight> parseHighlight(const proto::Highlight& message, const NamedSelectionMessages& named);

/// Complete: parsing it gives the value again, the colour to rounding.
proto::Highlight toProto(const Highlight& highlight);

void visitFields(Highlight& highlight, const Highlight& other, FieldVisitor& visitor);

/// Of paths: whose ways through all steps of a run are lines in the picture (docs/PICTURE.md, "Paths").
constexpr int mostPathIds = 1000;

/// Brings ids into order, without repetition. Errors: too many ids, a number out of range.
Result<proto::Paths> parsePaths(proto::Paths message);

// Towards: another step of a layer's dataset, and how far on the way there the layer is (docs/PICTURE.md,
// "Between steps"). A value.
struct Towards {
    std::uint32_t step = 0;  ///< index into the dataset's steps
    double share = 0.0;      ///< of the way from the layer's step to this one, 0 to 1

    bool operator==(const Towards&) const = default;
};

/// Into a layer whose style is there. Errors: of each part; one of a layer of a kind that does not have it.
Status parseLayerParts(const proto::Layer& message, const NamedSelectionMessages& named, Layer& layer);

void writeLayerParts(const Layer& layer, proto::Layer& message);

/// Shows all fields of style and parts of a layer beside those of another of the same kind.
void visitLayer(Layer& layer, const Layer& other, FieldVisitor& visitor);

/// How many ids and points the selections of the layer hold.
std::size_t valueCount(const Layer& layer);

}  // namespace mote
