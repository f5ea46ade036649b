// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/view.h"

#include <fmt/format.h>

#include <algorithm>
#include <type_traits>
#include <utility>

#include "protocol/base/utf8.h"
#include "protocol/scene/fields/facts.h"
#include "protocol/scene/fields/resolve.h"
#include "protocol/scene/layer_parts.h"
#include "protocol/scene/view_message.h"
#include "protocol/scene/write_fields.h"

namespace mote {
namespace {

Status checkSize(const proto::View& message) {
    const auto side = [](std::uint32_t pixels, const char* field) -> Status {
        if (pixels >= 1 && pixels <= View::maxSide) return success();
        if (pixels == 0)
            return invalid(field,
                           fmt::format("is missing: a picture has 1 to {} pixels a side", View::maxSide));
        return invalid(field,
                       fmt::format("a picture has 1 to {} pixels a side, not {}", View::maxSide, pixels));
    };
    MOTE_RETURN_IF_ERROR(side(message.width(), "width"));
    MOTE_RETURN_IF_ERROR(side(message.height(), "height"));
    const std::uint64_t pixels = std::uint64_t{message.width()} * message.height();
    if (pixels <= View::maxPixels) return success();
    return invalid("width", fmt::format("{} x {} is more than {} pixels in one picture", message.width(),
                                        message.height(), View::maxPixels));
}

Result<double> parseScale(const proto::View& message) {
    if (!message.has_scale()) return 1.0;
    if (message.scale() > 0.0 && message.scale() <= View::maxScale) return message.scale();
    return invalid("scale",
                   fmt::format("lies above 0 and is at most {}, not {}", View::maxScale, message.scale()));
}

/// What the message says is checked.
Status parseSpace(const proto::View& message, View& view) {
    if (message.space().empty() && message.stretch().empty()) return success();
    if (message.space().empty())
        return invalid("stretch", "is of places in metres: it needs \"space\": \"metres\"");
    view.metres.emplace();
    if (!message.stretch().empty()) view.metres->stretch = readVector(message.stretch());
    return success();
}

template <class Style>
Result<Layer> withStyle(Layer layer, Result<Style> style, std::string_view kind) {
    if (!style.ok()) return style.error().within(kind);
    layer.style = *std::move(style);
    return layer;
}

/// The names of all kinds of layers.
std::string kindNames() {
    const auto& kinds = *proto::Layer::descriptor()->FindOneofByName("kind");
    std::string names;
    for (int i = 0; i < kinds.field_count(); ++i) {
        if (i > 0) names += i + 1 < kinds.field_count() ? ", " : " and ";
        names += fmt::format("\"{}\"", kinds.field(i)->name());
    }
    return names;
}

/// Of a kind whose style is its message and nothing else: found by its type among those of a layer, from the
/// `first` on.
template <std::size_t first = 0>
Result<Layer> parseMessageStyle(const proto::Layer& message, Layer layer) {
    using Styles = decltype(layer.style);
    if constexpr (first < std::variant_size_v<Styles>) {
        using Style = std::variant_alternative_t<first, Styles>;
        if constexpr (std::is_base_of_v<google::protobuf::Message, Style>) {
            const auto& reflection = *message.GetReflection();
            const auto* const kind = reflection.GetOneofFieldDescriptor(
                message, proto::Layer::descriptor()->FindOneofByName("kind"));
            if (kind != nullptr && kind->message_type() == Style::descriptor()) {
                const auto& said = dynamic_cast<const Style&>(reflection.GetMessage(message, kind));
                return withStyle(std::move(layer), resolved(said), kind->name());
            }
        }
        return parseMessageStyle<first + 1>(message, std::move(layer));
    } else {
        return invalid("", "a layer holds exactly one kind; this version draws " + kindNames());
    }
}

/// A layer with its kind's style alone.
Result<Layer> parseStyle(const proto::Layer& message, const glm::dvec3& background, Layer layer) {
    switch (message.kind_case()) {
        case proto::Layer::kParticles:
            return withStyle(std::move(layer), parseParticlesStyle(message.particles()), "particles");
        case proto::Layer::kHybrid:
            return withStyle(std::move(layer), parseHybridStyle(message.hybrid()), "hybrid");
        case proto::Layer::kStipple:
            return withStyle(std::move(layer), parseStippleStyle(message.stipple(), background), "stipple");
        case proto::Layer::kInk:
            return withStyle(std::move(layer), parseInkStyle(message.ink(), background), "ink");
        default:
            return parseMessageStyle(message, std::move(layer));
    }
}

/// What people call a layer.
Status checkLayerName(const std::string& name) {
    if (name.size() > Layer::maxNameBytes)
        return invalid("name", fmt::format("has at most {} bytes, not {}", Layer::maxNameBytes, name.size()));
    if (!isUtf8(name)) return invalid("name", "is no UTF-8");
    for (std::string_view left = name; !left.empty();) {
        const auto character = left.substr(0, characterLength(left));
        if (isControl(character)) return invalid("name", "holds a control character");
        left.remove_prefix(character.size());
    }
    return success();
}

/// A hidden layer stays in its place, and nothing is there of it: whatever draws, fits, picks or labels
/// leaves it out as it does one that has faded away.
double opacityOf(const proto::Layer& message) {
    return message.hidden() ? 0.0 : numberOf(message, message.kOpacityFieldNumber);
}

Result<Layer> parseLayer(const proto::Layer& message, const proto::View& view, const glm::dvec3& background) {
    if (message.dataset().empty()) return invalid("dataset", "a layer needs a dataset, \"ROOT/NAME\"");
    MOTE_ASSIGN_OR_RETURN(const auto transform, parseTransform(message.transform()));
    MOTE_RETURN_IF_ERROR(checkLayerName(message.name()));
    MOTE_RETURN_IF_ERROR(checkOwnFields(message));
    auto layer =
        parseStyle(message, background,
                   {message.dataset(), message.step(), transform, StippleStyle{}, opacityOf(message)});
    if (layer.ok()) MOTE_RETURN_IF_ERROR(parseLayerParts(message, view.selections(), *layer));
    if (layer.ok() && layer->ink()) layer->inkIsDark = inkIsDark(*layer->ink(), background);
    return layer;
}

Status parseLayers(const proto::View& message, View& view) {
    if (message.layers_size() > View::maxLayers) {
        return invalid("layers", fmt::format("a view has at most {} layers, not {}", View::maxLayers,
                                             message.layers_size()));
    }
    std::size_t values = 0;
    for (int i = 0; i < message.layers_size(); ++i) {
        auto layer = parseLayer(message.layers(i), message, view.background);
        MOTE_RETURN_IF_ERROR(layer, fmt::format("layers[{}]", i));
        values += valueCount(*layer);
        if (values > Selection::maxValues) {
            return invalid(fmt::format("layers[{}]", i),
                           fmt::format("the selections of all layers have more than {} ids and points",
                                       Selection::maxValues));
        }
        view.layers.push_back(*std::move(layer));
    }
    return success();
}

bool isDrawing(const proto::Layer& layer) {
    return layer.has_ink() || layer.has_stipple();
}

/// As it is said, or white for drawings, black for what gives light; an image may lie behind either.
glm::dvec3 parseBackground(const proto::View& message) {
    if (const auto said = colorOf(message, message.kBackgroundFieldNumber)) return *said;
    const auto& layers = message.layers();
    const auto seen = [](const proto::Layer& layer) { return !layer.has_image() && opacityOf(layer) > 0.0; };
    const bool any = std::any_of(layers.begin(), layers.end(), seen);
    const bool drawing = std::all_of(layers.begin(), layers.end(), [&](const proto::Layer& layer) {
        return isDrawing(layer) || layer.has_image() || (any && !seen(layer));
    });
    return glm::dvec3(drawing && std::any_of(layers.begin(), layers.end(), isDrawing) ? 1.0 : 0.0);
}

/// Of those of which there is something.
Bounds layersBounds(const std::vector<Layer>& layers) {
    std::optional<Bounds> bounds;
    for (const auto& layer : layers) {
        if (!(layer.opacity > 0.0) || layer.image()) continue;
        const Bounds here = plotBounds.transformed(layer.transform);
        bounds = bounds ? bounds->united(here) : here;
    }
    return bounds.value_or(plotBounds);
}

}  // namespace

bool Layer::onScreen() const {
    return image() || (stipple() && onPlane(*stipple()));
}

HalfSpaces Layer::clips() const {
    HalfSpaces clips = clip ? halfSpacesOf(*clip) : HalfSpaces();
    if (const auto* const style = hybrid()) {
        const auto own =
            halfSpacesOf(style->clip_planes(), style->has_clip_box() ? &style->clip_box() : nullptr);
        clips.insert(clips.end(), own.begin(), own.end());
    }
    return clips;
}

Result<View> parseView(const proto::View& message) {
    MOTE_RETURN_IF_ERROR(checkSize(message));
    View view;
    view.width = message.width();
    view.height = message.height();
    MOTE_ASSIGN_OR_RETURN(view.scale, parseScale(message));
    MOTE_RETURN_IF_ERROR(checkOwnFields(message));
    MOTE_RETURN_IF_ERROR(parseSpace(message, view));
    view.background = parseBackground(message);
    view.depthContrast = numberOf(message, message.kDepthContrastFieldNumber);
    auto selections = parseNamedSelections(message.selections());
    MOTE_RETURN_IF_ERROR(selections, "selections");
    view.selections = *std::move(selections);
    MOTE_RETURN_IF_ERROR(parseLayers(message, view));
    MOTE_RETURN_IF_ERROR(checkLengths(view));
    if (message.has_annotations()) {
        MOTE_RETURN_IF_ERROR(checkAnnotations(message.annotations()), "annotations");
        view.annotations = message.annotations();
    }
    if (!message.has_camera()) {
        view.camera = fitCamera(layersBounds(view.layers), view.aspect());
        view.cameraFitted = true;
        return view;
    }
    const auto camera = parseCamera(message.camera());
    if (!camera.ok()) return camera.error().within("camera");
    view.camera = *camera;
    return view;
}

}  // namespace mote
