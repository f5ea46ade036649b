// SPDX-License-Identifier: GPL-3.0-or-later
//
// View: what one picture shows: its size, its camera and its layers, which share one depth. A value; a parsed
// one is valid in itself (whether its datasets exist, the catalogue knows).
#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/annotations.h"
#include "protocol/scene/camera.h"
#include "protocol/scene/clip.h"
#include "protocol/scene/hybrid_style.h"
#include "protocol/scene/ink_style.h"
#include "protocol/scene/layer_parts.h"
#include "protocol/scene/particles_style.h"
#include "protocol/scene/selection.h"
#include "protocol/scene/stipple_style.h"

namespace mote {

/// The look of a mesh (docs/PICTURE.md, "Meshes"): its message, resolved (fields/resolve.h).
using MeshStyle = proto::MeshStyle;

struct Layer {
    static constexpr std::size_t maxNameBytes = 200;  ///< of what people call it, which only the message has

    std::string dataset;        ///< "ROOT/NAME"
    std::uint32_t step = 0;     ///< index into the dataset's steps
    glm::dmat4 transform{1.0};  ///< layer space to world space, affine and invertible
    std::variant<proto::ParticlesStyle, proto::HybridStyle, StippleStyle, MeshStyle, proto::InkStyle,
                 proto::ImageStyle>
        style;
    /// How much of it there is, 0 to 1 (docs/PICTURE.md, "Layers that fade"); of a hidden one nothing.
    double opacity = 1.0;
    // Of particles alone.
    std::optional<proto::ColorBy> colorBy = {};  ///< of its points, resolved
    std::optional<Selection> select = {};        ///< these are drawn, as if they were the whole run
    std::optional<Highlight> highlight = {};     ///< these are drawn over the others
    std::optional<proto::Paths> paths = {};      ///< the ways of some through all steps, checked
    // Of kinds that have steps.
    std::optional<Towards> towards = {};   ///< another step, and how far on the way there the layer is
    std::optional<proto::Clip> clip = {};  ///< what is cut away, checked
    bool inkIsDark = true;                 ///< of ink: no lighter than its paper, it stands for what is dark

    /// Null where it is of another kind.
    const proto::ParticlesStyle* particles() const { return std::get_if<proto::ParticlesStyle>(&style); }
    proto::ParticlesStyle* particles() { return std::get_if<proto::ParticlesStyle>(&style); }
    const proto::HybridStyle* hybrid() const { return std::get_if<proto::HybridStyle>(&style); }
    const StippleStyle* stipple() const { return std::get_if<StippleStyle>(&style); }
    const proto::InkStyle* ink() const { return std::get_if<proto::InkStyle>(&style); }
    const MeshStyle* mesh() const { return std::get_if<MeshStyle>(&style); }
    const proto::ImageStyle* image() const { return std::get_if<proto::ImageStyle>(&style); }
    /// It lies on the screen, behind all that has a place in space: an image, or one that is stippled.
    bool onScreen() const;
    /// In all of which lies what is drawn of it, layer space: its own clip, and a hybrid style's planes and
    /// box.
    HalfSpaces clips() const;

    bool operator==(const Layer&) const = default;
};

/// How layers lie together where each lies in metres (metres.h).
struct Metres {
    glm::dvec3 stretch{1.0};  ///< world units of a metre along x, y and z
    bool placed = false;      ///< the layers' transforms take them to the world; else they stay in metres

    bool operator==(const Metres&) const = default;
};

struct View {
    static constexpr std::uint32_t maxSide = 16384;         ///< pixels
    static constexpr std::uint64_t maxPixels = 1ULL << 25;  ///< 8K and a little more
    static constexpr int maxLayers = 8;
    static constexpr double maxScale = 64.0;

    std::uint32_t width = 0;     ///< pixels
    std::uint32_t height = 0;    ///< pixels
    double scale = 1.0;          ///< of the lengths on the screen that it says (length_scale.h)
    glm::dvec3 background{0.0};  ///< linear RGB; white if nobody says it and all layers are drawings
    Camera camera;               ///< fitted to the layers where the message has none
    bool cameraFitted = false;   ///< the message had none: it was fitted as if every layer were a plot
    std::vector<Layer> layers;
    /// What the axes of each layer stand around: the box of what it shows, layer space; empty: the whole
    /// plot.
    std::vector<std::optional<Bounds>> shown = {};
    std::optional<proto::Annotations> annotations = {};  ///< checked
    std::optional<Metres> metres = {};                   ///< none: the world has no unit
    double depthContrast = 0.0;                          ///< 0 to 1 (docs/PICTURE.md, "Depth contrast")
    std::vector<NamedSelection> selections = {};         ///< that stay with it; those of layers are resolved

    double aspect() const { return static_cast<double>(width) / height; }
    bool operator==(const View&) const = default;
};

/// Errors name the field: "layers[0].particles.volume.curve[1]".
Result<View> parseView(const proto::View& message);

}  // namespace mote
