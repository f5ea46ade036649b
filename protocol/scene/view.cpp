// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/view.h"

#include <fmt/format.h>

#include <cmath>
#include <glm/matrix.hpp>

#include "protocol/scene/check.h"

namespace mote {
namespace {

Error invalid(std::string where, std::string message) {
    return {ErrorCode::invalidArgument, std::move(where), std::move(message)};
}

Status checkSize(const proto::View& message) {
    const auto side = [](std::uint32_t pixels, const char* field) -> Status {
        if (pixels >= 1 && pixels <= View::maxSide) return success();
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

Result<glm::dmat4> parseTransform(const google::protobuf::RepeatedField<double>& rows) {
    if (rows.empty()) return glm::dmat4(1.0);
    if (rows.size() != 16) {
        return invalid("transform", fmt::format("16 numbers are needed, not {}", rows.size()));
    }
    glm::dmat4 transform(1.0);
    for (int i = 0; i < 16; ++i) {
        MOTE_RETURN_IF_ERROR(checkRange(rows[i], -1e9, 1e9, fmt::format("transform[{}]", i)));
        transform[i % 4][i / 4] = rows[i];  // glm keeps columns
    }
    if (rows[12] != 0.0 || rows[13] != 0.0 || rows[14] != 0.0 || rows[15] != 1.0) {
        return invalid("transform", "the last row must be 0, 0, 0, 1");
    }
    const double determinant = std::abs(glm::determinant(glm::dmat3(transform)));
    if (!(determinant > 1e-18 && determinant < 1e18)) {
        return invalid("transform", "the matrix must be invertible and of sensible scale");
    }
    return transform;
}

template <class Style>
Result<Layer> withStyle(Layer layer, Result<Style> style, std::string_view kind) {
    if (!style.ok()) return style.error().within(kind);
    layer.style = *std::move(style);
    return layer;
}

Result<Layer> parseLayer(const proto::Layer& message, const glm::dvec3& background) {
    if (message.dataset().empty()) return invalid("dataset", "a layer needs a dataset, \"ROOT/NAME\"");
    MOTE_ASSIGN_OR_RETURN(const auto transform, parseTransform(message.transform()));
    const double opacity = message.has_opacity() ? message.opacity() : 1.0;
    MOTE_RETURN_IF_ERROR(checkRange(opacity, 0.0, 1.0, "opacity"));
    const Layer layer{message.dataset(), message.step(), transform, StippleStyle{}, opacity};
    switch (message.kind_case()) {
        case proto::Layer::kParticles:
            return withStyle(layer, parseParticlesStyle(message.particles()), "particles");
        case proto::Layer::kHybrid:
            return withStyle(layer, parseHybridStyle(message.hybrid()), "hybrid");
        case proto::Layer::kStipple:
            return withStyle(layer, parseStippleStyle(message.stipple(), background), "stipple");
        case proto::Layer::kInk:
            return withStyle(layer, parseInkStyle(message.ink(), background), "ink");
        case proto::Layer::kMesh:
            return withStyle(layer, parseMeshStyle(message.mesh()), "mesh");
        default:
            return invalid("",
                           "a layer holds exactly one kind; this version draws \"particles\", \"hybrid\", "
                           "\"stipple\", \"ink\" and \"mesh\"");
    }
}

/// Of those of which there is something.
Bounds layersBounds(const std::vector<Layer>& layers) {
    std::optional<Bounds> bounds;
    for (const auto& layer : layers) {
        if (!(layer.opacity > 0.0)) continue;
        const Bounds here = plotBounds.transformed(layer.transform);
        bounds = bounds ? bounds->united(here) : here;
    }
    return bounds.value_or(plotBounds);
}

}  // namespace

Result<View> parseView(const proto::View& message) {
    MOTE_RETURN_IF_ERROR(checkSize(message));
    View view;
    view.width = message.width();
    view.height = message.height();
    MOTE_ASSIGN_OR_RETURN(view.background, checkColor(message.background(), glm::dvec3(0.0), "background"));
    if (message.layers_size() > View::maxLayers) {
        return invalid("layers", fmt::format("a view has at most {} layers, not {}", View::maxLayers,
                                             message.layers_size()));
    }
    for (int i = 0; i < message.layers_size(); ++i) {
        auto layer = parseLayer(message.layers(i), view.background);
        if (!layer.ok()) return layer.error().within(fmt::format("layers[{}]", i));
        view.layers.push_back(*std::move(layer));
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
