// SPDX-License-Identifier: GPL-3.0-or-later
//
// The look of an ink layer, a pen-and-ink drawing of a mesh, a hybrid volume or particles (docs/INK.md): its
// message, resolved (fields/resolve.h), and InkStyle, which is made of it for who draws. Values and pure
// functions.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/curve.h"
#include "protocol/scene/length_scale.h"
#include "protocol/scene/light.h"

namespace mote {

enum class SilhouetteMode { none, all, important, adjusted };

inline constexpr int mostInkRegions = 64, mostInkDabs = 4096;  ///< of a style; of a region

struct SilhouetteStyle {
    SilhouetteMode mode;
    double importance;        ///< step above which a line is always drawn, 0 to 1 (LinePoint::step)
    ScreenLength width;       ///< pixels of the view; here and below
    double crease;            ///< degrees by which the surface turns at least where a crease is a line
    bool omit;                ///< lines between tones that differ enough are left out
    bool suggestive = false;  ///< of a mesh: lines too where a contour would appear if the eye moved a little

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

/// Watercolour under the lines.
struct WashStyle {
    bool everywhere;     ///< else only in regions that are painted so
    glm::dvec3 color;    ///< what all layers together leave of white paper, linear RGB
    double strength;     ///< share of the missing tone that is washed
    int tones;           ///< layers over one another at most
    double edges;        ///< how much more pigment dries at the edge of a layer
    double granulation;  ///< how much pigment settles in the paper's grain
    ScreenLength bleed;  ///< how far layers run over outlines

    bool operator==(const WashStyle&) const = default;
};

/// How a region that somebody painted is drawn.
enum class RegionFill { usual, hatch, ink, wash, none };

/// What somebody painted on the surface by hand, in layer space.
struct PaintedRegion {
    std::vector<glm::dvec3> dabs;  ///< their middles
    double radius;                 ///< of each dab
    bool whole;                    ///< all regions of the picture that the dabs touch; else what is painted
    RegionFill fill;
    std::optional<double> direction;  ///< of its hatches, degrees from the picture's x axis, upwards

    bool operator==(const PaintedRegion&) const = default;
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
    WashStyle wash;
    std::vector<PaintedRegion> regions = {};  ///< later ones lie over earlier ones

    bool operator==(const InkStyle&) const = default;
};

/// Fills every default; `background` (linear RGB) is the paper. Errors: a number out of range, a word that is
/// not known, a curve that descends, dabs that are no places or too many.
Result<proto::InkStyle> parseInkStyle(proto::InkStyle message, const glm::dvec3& background);

/// Whether the ink of a parsed message stands for what is dark: it is no lighter than its paper.
bool inkIsDark(const proto::InkStyle& message, const glm::dvec3& background);

/// Of a parsed message.
InkStyle inkStyleOf(const proto::InkStyle& message, bool inkIsDark = true);

}  // namespace mote
