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

void put(ByteWriter& out, const RankSteps::Name& name) {
    out.putList(name.file);
    out.putList(name.digest);
    out.put(name.parts);
}

RankSteps::Name getName(ByteReader& in) {
    return {.file = in.getList<std::string>(),
            .digest = in.getList<std::string>(),
            .parts = in.get<HybridRepresentation>()};
}

void put(ByteWriter& out, const TransferFunction& transfer) {
    out.putList(transfer.opacity.knots());
    out.put(transfer.opacityLength);
    out.put(transfer.fade);
    out.putList(transfer.colorMap.name());
    out.put(transfer.colorRange);
    out.putList(transfer.colors);
    out.put(transfer.span);
}

Curve getCurve(ByteReader& in) {
    constexpr double any = std::numeric_limits<double>::infinity();
    return *Curve::create(in.getList<std::vector<Curve::Knot>>(), -any, any);
}

/// Reads in order: an initialiser's parts are read from left to right.
TransferFunction getTransfer(ByteReader& in) {
    return {.opacity = getCurve(in),
            .opacityLength = in.get<double>(),
            .fade = in.get<double>(),
            .colorMap = *ColorMap::find(in.getList<std::string>()),
            .colorRange = in.get<ValueRange>(),
            .colors = in.getList<std::vector<glm::dvec3>>(),
            .span = in.get<ValueRange>()};
}

void put(ByteWriter& out, const PointsPlan& points) {
    out.put(points.layer);
    out.put(points.boxToEye);
    out.put(points.look);
    out.putList(points.fraction.knots());
    MOTE_CHECK(points.preview == nullptr);
    out.put(points.selection->points > 0);
    out.putList(points.leavesInView);
    out.put(points.pointsDrawn);
    out.put(points.share);
}

PointsPlan getPoints(ByteReader& in) {
    PointsPlan points{.layer = in.get<std::size_t>(),
                      .boxToEye = in.get<glm::dmat4>(),
                      .look = in.get<PointLook>(),
                      .fraction = getCurve(in)};
    if (!in.get<bool>()) points.selection = std::make_shared<const PointSelection>();
    points.leavesInView = in.getList<std::vector<std::uint64_t>>();
    points.pointsDrawn = in.get<std::uint64_t>();
    points.share = in.get<double>();
    return points;
}

void put(ByteWriter& out, const FieldPlan& field) {
    out.put(field.layer);
    out.put(field.boxToEye);
    out.put(field.boxToLayer);
    put(out, field.transfer);
    out.putList(field.clips);
    const auto* const samples = field.grid();
    out.put(samples != nullptr);
    if (samples == nullptr) return;
    out.put(samples->bricks);
    out.put(samples->correction);
    out.put(samples->steepness);
    out.put(samples->shades);
}

FieldPlan getField(ByteReader& in) {
    FieldPlan field{.layer = in.get<std::size_t>(),
                    .boxToEye = in.get<glm::dmat4>(),
                    .boxToLayer = in.get<glm::dmat3>(),
                    .transfer = getTransfer(in),
                    .clips = in.getList<std::vector<HalfSpace>>(),
                    .samples = {}};
    if (!in.get<bool>()) return field;
    field.samples = CorrectedField{.grid = {},
                                   .bricks = in.get<bool>(),
                                   .correction = in.get<double>(),
                                   .steepness = in.get<double>(),
                                   .shades = in.get<Shades>()};
    return field;
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
    out.put(std::uint64_t{plan.points.size()});
    for (const auto& points : plan.points) put(out, points);
    out.put(std::uint64_t{plan.fields.size()});
    for (const auto& field : plan.fields) put(out, field);
    out.putList(plan.dots ? *plan.dots : Dots());
    out.put(std::uint64_t{plan.fragments.size()});
    for (const auto& fragments : plan.fragments) out.putList(*fragments);
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
                   .exact = in.get<bool>()};
    const auto points = in.get<std::uint64_t>();
    for (std::uint64_t i = 0; i < points; ++i) plan.points.push_back(getPoints(in));
    const auto fields = in.get<std::uint64_t>();
    for (std::uint64_t i = 0; i < fields; ++i) plan.fields.push_back(getField(in));
    plan.dots = std::make_shared<const Dots>(in.getList<Dots>());
    const auto surfaces = in.get<std::uint64_t>();
    for (std::uint64_t i = 0; i < surfaces; ++i)
        plan.fragments.push_back(std::make_shared<const Fragments>(in.getList<Fragments>()));
    return plan;
}

}  // namespace

Bytes packOrder(const FrameOrder& order) {
    ByteWriter out;
    out.put(order.number);
    out.put(order.format);
    out.put(order.flatPoints.has_value());
    out.put(order.flatPoints.value_or(0));
    put(out, order.plan);
    for (const auto& step : order.pointSteps) put(out, step);
    for (const auto& step : order.fieldSteps) put(out, step);
    return out.take();
}

FrameOrder unpackOrder(const Bytes& bytes) {
    ByteReader in(bytes);
    FrameOrder order;
    order.number = in.get<std::uint64_t>();
    order.format = in.get<PixelFormat>();
    const bool flat = in.get<bool>();
    const auto only = in.get<std::uint32_t>();
    if (flat) order.flatPoints = only;
    order.plan = getPlan(in);
    for (std::size_t i = 0; i < order.plan.points.size(); ++i) order.pointSteps.push_back(getName(in));
    for (std::size_t i = 0; i < order.plan.fields.size(); ++i) order.fieldSteps.push_back(getName(in));
    MOTE_CHECK(in.atEnd());
    return order;
}

}  // namespace mote::render
