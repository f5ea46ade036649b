// SPDX-License-Identifier: GPL-3.0-or-later
//
// InkStyle: the look of an ink layer, a pen-and-ink drawing of a mesh, a hybrid volume or particles
// (docs/INK.md). A value; a parsed one is valid.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <string_view>

#include "protocol/mote.pb.h"
#include "protocol/scene/curve.h"
#include "protocol/scene/error.h"
#include "protocol/scene/length_scale.h"
#include "protocol/scene/light.h"

namespace mote {

enum class SilhouetteMode { none, all, important, adjusted };

struct SilhouetteStyle {
    SilhouetteMode mode = SilhouetteMode::adjusted;
    double importance = 1.0;  ///< step above which a line is always drawn, 0 to 1 (LinePoint::step)
    ScreenLength width = ScreenLength::usual(1.2);  ///< pixels of the view; here and below
    double crease = 60.0;  ///< degrees by which the surface turns at least where a crease is a line
    bool omit = false;     ///< lines between tones that differ enough are left out

    bool operator==(const SilhouetteStyle&) const = default;
};

/// How a picture is parted into regions that are hatched in one direction.
enum class Segmentation { growing, graph, cut, texture };

struct HatchStyle {
    double strength = 1.0;                            ///< share of the missing tone that is hatched
    ScreenLength spacing = ScreenLength::usual(4.0);  ///< between the strokes of a full layer
    ScreenLength width = ScreenLength::usual(1.0);
    Segmentation segments = Segmentation::growing;

    bool operator==(const HatchStyle&) const = default;
};

/// What of complex regions is inked solid, instead of lines and hatches there.
struct SolidStyle {
    double strength = 0.0;    ///< tones above 1 - strength are; 0: there is no such style
    double complexity = 0.3;  ///< what lines would cover, from which on a region is complex

    bool operator==(const SolidStyle&) const = default;
};

/// What an ink layer shows: its drawing, or a picture that this is made from.
enum class InkPicture { drawing, grey, depth, angle, edges, complexity, segments, target, lighten, darken };

struct InkStyle {
    SilhouetteStyle silhouettes;
    HatchStyle hatch;
    SolidStyle solid;
    ScreenLength reading = ScreenLength::usual(6.0);  ///< standard deviation of what the eye blurs
    Light light;
    double occlusion = 0.0;  ///< of the ambient light, the share that surroundings can keep away
    glm::dvec3 color{0.0};   ///< linear RGB
    bool inkIsDark = true;   ///< darker than the paper: it stands for what is dark; else for what is light
    InkPicture show = InkPicture::drawing;
    ScreenLength waver = ScreenLength::usual(0.0);
    bool taper = false;
    /// What is seen of a volume (by value) or of particles (by scaled log density), as their own layers have
    /// it; none: as the dataset's values ask.
    std::optional<Curve> opacity;
    bool coherent = false;  ///< strokes are kept from the picture before where they can be

    bool operator==(const InkStyle&) const = default;
};

/// Fills every default; `background` is linear RGB. Errors: a number out of range, a word that is not known,
/// a curve that descends.
Result<InkStyle> parseInkStyle(const proto::InkStyle& message, const glm::dvec3& background);

/// The message of such a style, filled in but for its colour. Errors likewise.
Result<proto::InkStyle> resolvedInk(proto::InkStyle message);

/// Words of the style, as messages have them; "" is the first's.
std::string_view toString(SilhouetteMode mode);
std::string_view toString(Segmentation segments);
std::string_view toString(InkPicture picture);

}  // namespace mote
