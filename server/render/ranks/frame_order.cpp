// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ranks/frame_order.h"

#include <limits>

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

template <class Value>
void put(ByteWriter& out, const std::optional<Value>& value) {
    out.put(value.has_value());
    if (value) out.put(*value);
}

template <class Value>
std::optional<Value> getOptional(ByteReader& in) {
    if (!in.get<bool>()) return std::nullopt;
    return in.get<Value>();
}

void put(ByteWriter& out, const RankSteps::Name& name) {
    out.putList(name.file);
    out.putList(name.digest);
}

RankSteps::Name getName(ByteReader& in) {
    auto file = in.getList<std::string>();
    return {std::move(file), in.getList<std::string>()};
}

void put(ByteWriter& out, const HybridStyle& style) {
    out.put(style.representation);
    out.put(style.opacity.has_value());
    if (style.opacity) out.putList(style.opacity->knots());
    out.putList(style.colors);
    out.putList(style.colorMap.name());
    put(out, style.colorRange);
    out.put(style.pointShape);
    out.put(style.pointOpacity);
    out.put(style.light);
    out.putList(style.clipPlanes);
    put(out, style.clipBox);
}

HybridStyle getHybridStyle(ByteReader& in) {
    constexpr double anyValue = std::numeric_limits<double>::infinity();
    HybridStyle style;
    style.representation = in.get<HybridRepresentation>();
    if (in.get<bool>())
        style.opacity = *Curve::create(in.getList<std::vector<Curve::Knot>>(), -anyValue, anyValue);
    style.colors = in.getList<std::vector<glm::dvec3>>();
    style.colorMap = *ColorMap::find(in.getList<std::string>());
    style.colorRange = getOptional<ValueRange>(in);
    style.pointShape = in.get<PointShape>();
    style.pointOpacity = in.get<double>();
    style.light = in.get<Light>();
    style.clipPlanes = in.getList<std::vector<HalfSpace>>();
    style.clipBox = getOptional<Bounds>(in);
    return style;
}

void put(ByteWriter& out, const FrameOrder::Hybrid& layer) {
    put(out, layer.step);
    put(out, layer.style);
    out.put(layer.layerToWorld);
}

FrameOrder::Hybrid getHybrid(ByteReader& in) {
    return {.step = getName(in), .style = getHybridStyle(in), .layerToWorld = in.get<glm::dmat4>()};
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
    out.putList(plan.sections);
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
                   .sections = in.getList<std::vector<DepthSection>>(),
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
    for (const auto& step : order.steps) put(out, step);
    out.put(std::uint64_t{order.hybrids.size()});
    for (const auto& layer : order.hybrids) put(out, layer);
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
    for (std::size_t i = 0; i < order.plan.layers.size(); ++i) order.steps.push_back(getName(in));
    const auto hybrids = in.get<std::uint64_t>();
    for (std::uint64_t i = 0; i < hybrids; ++i) order.hybrids.push_back(getHybrid(in));
    MOTE_CHECK(in.atEnd());
    return order;
}

}  // namespace mote::render
