// SPDX-License-Identifier: GPL-3.0-or-later
//
// The look of an ink layer, a pen-and-ink drawing of a mesh, a hybrid volume or particles (docs/INK.md): its
// message, resolved (fields/resolve.h), and InkStyle, which is made of it for who draws. Values and pure
// functions.
#pragma once

#include <glm/vec3.hpp>
#include <optional>

#include "protocol/mote.pb.h"
#include "protocol/scene/curve.h"
#include "protocol/scene/error.h"
#include "protocol/scene/length_scale.h"
#include "protocol/scene/light.h"

namespace mote {

enum class SilhouetteMode { none, all, important, adjusted };

struct SilhouetteStyle {
    SilhouetteMode mode;
    double importance;   ///< step above which a line is always drawn, 0 to 1 (LinePoint::step)
    ScreenLength width;  ///< pixels of the view; here and below
    double crease;       ///< degrees by which the surface turns at least where a crease is a line
    bool omit;           ///< lines between tones that differ enough are left out

    bool operator==(const SilhouetteStyle&) const = default;
};

/// How a picture is parted into regions that are hatched in one direction.
enum class Segmentation { growing, graph, cut, texture };

struct HatchStyle {
    double strength;       ///< share of the missing tone that is hatched
    ScreenLength spacing;  ///< between the strokes of a full layer
    ScreenLength width;
    Segmentation segments;

    bool operator==(const HatchStyle&) const = default;
};

/// What of complex regions is inked solid, instead of lines and hatches there.
struct SolidStyle {
    double strength;    ///< tones above 1 - strength are; 0: there is no such style
    double complexity;  ///< what lines would cover, from which on a region is complex

    bool operator==(const SolidStyle&) const = default;
};

/// What an ink layer shows: its drawing, or a picture that this is made from.
enum class InkPicture { drawing, grey, depth, angle, edges, complexity, segments, target, lighten, darken };

/// As drawn.
struct InkStyle {
    SilhouetteStyle silhouettes;
    HatchStyle hatch;
    SolidStyle solid;
    ScreenLength reading;  ///< standard deviation of what the eye blurs
    Light light;
    double occlusion;  ///< of the ambient light, the share that surroundings can keep away
    glm::dvec3 color;  ///< linear RGB
    bool inkIsDark;    ///< darker than the paper: it stands for what is dark; else for what is light
    InkPicture show;
    ScreenLength waver;
    bool taper;
    /// What is seen of a volume (by value) or of particles (by scaled log density), as their own layers have
    /// it; none: as the dataset's values ask.
    std::optional<Curve> opacity;
    bool coherent;  ///< strokes are kept from the picture before where they can be

    bool operator==(const InkStyle&) const = default;
};

/// Fills every default; `background` (linear RGB) is the paper. Errors: a number out of range, a word that is
/// not known, a curve that descends.
Result<proto::InkStyle> parseInkStyle(proto::InkStyle message, const glm::dvec3& background);

/// Whether the ink of a parsed message stands for what is dark: it is no lighter than its paper.
bool inkIsDark(const proto::InkStyle& message, const glm::dvec3& background);

/// Of a parsed message.
InkStyle inkStyleOf(const proto::InkStyle& message, bool inkIsDark = true);

}  // namespace mote
