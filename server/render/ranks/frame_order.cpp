// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ranks/frame_order.h"

#include "server/render/ranks/byte_stream.h"

namespace mote::render {
namespace {

void put(ByteWriter& out, const Camera& camera) {
    out.put(camera.eye);
    out.put(camera.target);
    out.put(camera.up);
    out.put(camera.fovYDegrees);
    out.put(camera.perspective());
    out.put(camera.orthographicHeight.value_or(0.0));
}

Camera getCamera(ByteReader& in) {
    Camera camera;
    camera.eye = in.get<glm::dvec3>();
    camera.target = in.get<glm::dvec3>();
    camera.up = in.get<glm::dvec3>();
    camera.fovYDegrees = in.get<double>();
    const bool perspective = in.get<bool>();
    const auto height = in.get<double>();
    if (!perspective) camera.orthographicHeight = height;
    return camera;
}

void put(ByteWriter& out, const ParticlesStyle& style) {
    out.putList(style.volumeOpacity.knots());
    out.putList(style.colorMap.name());
    out.putList(style.pointFraction.knots());
    out.put(style.pointOpacity);
    out.put(style.pointSize);
    out.put(style.pointColor);
}

/// In order: an initialiser's parts are read from left to right.
ParticlesStyle getStyle(ByteReader& in) {
    return ParticlesStyle{.volumeOpacity = *Curve::create(in.getList<std::vector<Curve::Knot>>()),
                          .colorMap = *ColorMap::find(in.getList<std::string>()),
                          .pointFraction = *Curve::create(in.getList<std::vector<Curve::Knot>>()),
                          .pointOpacity = in.get<double>(),
                          .pointSize = in.get<double>(),
                          .pointColor = in.get<glm::dvec3>()};
}

void put(ByteWriter& out, const LayerPlan& layer) {
    out.put(layer.layerToEye);
    put(out, layer.style);
    MOTE_CHECK(layer.preview == nullptr);
    out.put(layer.selection->points > 0);
    out.putList(layer.leavesInView);
    out.put(layer.pointsDrawn);
    out.put(layer.share);
}

LayerPlan getLayer(ByteReader& in) {
    LayerPlan layer{.step = {},
                    .layerToEye = in.get<glm::dmat4>(),
                    .style = getStyle(in),
                    .selection = {},
                    .leavesInView = {},
                    .preview = {}};
    if (!in.get<bool>()) layer.selection = std::make_shared<const PointSelection>();
    layer.leavesInView = in.getList<std::vector<std::uint64_t>>();
    layer.pointsDrawn = in.get<std::uint64_t>();
    layer.share = in.get<double>();
    return layer;
}

void put(ByteWriter& out, const FramePlan& plan) {
    out.put(plan.width);
    out.put(plan.height);
    put(out, plan.camera);
    out.put(plan.background);
    out.put(plan.nearDepth);
    out.put(plan.farDepth);
    out.put(plan.slabs);
    out.put(plan.samplesPerCell);
    out.put(plan.exact);
    out.put(std::uint64_t{plan.layers.size()});
    for (const auto& layer : plan.layers) put(out, layer);
    out.putList(plan.anyDots() ? *plan.dots : Dots());
}

FramePlan getPlan(ByteReader& in) {
    FramePlan plan{.width = in.get<std::uint32_t>(),
                   .height = in.get<std::uint32_t>(),
                   .camera = getCamera(in),
                   .background = in.get<glm::dvec3>(),
                   .nearDepth = in.get<double>(),
                   .farDepth = in.get<double>(),
                   .slabs = in.get<std::uint32_t>(),
                   .samplesPerCell = in.get<double>(),
                   .exact = in.get<bool>(),
                   .layers = {}};
    const auto layers = in.get<std::uint64_t>();
    for (std::uint64_t i = 0; i < layers; ++i) plan.layers.push_back(getLayer(in));
    plan.dots = std::make_shared<const Dots>(in.getList<Dots>());
    return plan;
}

}  // namespace

Bytes packOrder(const FrameOrder& order) {
    ByteWriter out;
    out.put(order.number);
    out.put(order.format);
    out.put(order.flatLayer.has_value());
    out.put(order.flatLayer.value_or(0));
    put(out, order.plan);
    for (const auto& step : order.steps) {
        out.putList(step.file);
        out.putList(step.digest);
    }
    return out.take();
}

FrameOrder unpackOrder(const Bytes& bytes) {
    ByteReader in(bytes);
    FrameOrder order;
    order.number = in.get<std::uint64_t>();
    order.format = in.get<PixelFormat>();
    const bool flat = in.get<bool>();
    const auto layer = in.get<std::uint32_t>();
    if (flat) order.flatLayer = layer;
    order.plan = getPlan(in);
    for (std::size_t i = 0; i < order.plan.layers.size(); ++i) {
        auto file = in.getList<std::string>();
        order.steps.push_back({std::move(file), in.getList<std::string>()});
    }
    MOTE_CHECK(in.atEnd());
    return order;
}

}  // namespace mote::render
