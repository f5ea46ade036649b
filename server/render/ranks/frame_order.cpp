// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ranks/frame_order.h"

#include <limits>

#include "server/render/ranks/byte_stream.h"

namespace mote::render {
namespace {

// What an order is made of is said once, and passed one way or the other. A part is copied as it lies, a list
// behind its length.

template <class Part>
concept List = requires(Part part) {
    part.resize(0);
};

class Packing {
  public:
    static constexpr bool reads = false;
    template <class... Parts>
    void operator()(const Parts&... parts) {
        (put(parts), ...);
    }
    Bytes take() { return out_.take(); }

  private:
    template <class Part>
    void put(const Part& part) {
        if constexpr (List<Part>) {
            out_.putList(part);
        } else {
            out_.put(part);
        }
    }
    void put(const Curve& curve) { out_.putList(curve.knots()); }
    void put(const ColorMap& map) { out_.putList(map.name()); }

    ByteWriter out_;
};

class Unpacking {
  public:
    static constexpr bool reads = true;
    explicit Unpacking(std::span<const std::byte> bytes) : in_(bytes) {}
    template <class... Parts>
    void operator()(Parts&... parts) {
        (get(parts), ...);
    }
    bool atEnd() const { return in_.atEnd(); }

  private:
    template <class Part>
    void get(Part& part) {
        if constexpr (List<Part>) {
            part = in_.getList<Part>();
        } else {
            part = in_.get<Part>();
        }
    }
    void get(Curve& curve) {
        constexpr double any = std::numeric_limits<double>::infinity();
        curve = *Curve::create(in_.getList<std::vector<Curve::Knot>>(), -any, any);
    }
    void get(ColorMap& map) { map = *ColorMap::find(in_.getList<std::string>()); }

    ByteReader in_;
};

/// `fresh`: what each is before it is read. `most`: of them a layer.
template <class Way, class Values, class Pass>
void passEach(Way& way, Values& values, const typename Values::value_type& fresh, Pass pass,
              std::uint64_t most = 1) {
    std::uint64_t count = values.size();
    way(count);
    MOTE_CHECK(count <= most * View::maxLayers);
    if constexpr (Way::reads) values.assign(count, fresh);
    for (auto& value : values) pass(value);
}

/// An immutable list; null is empty.
template <class Way, class Shared>
void passShared(Way& way, Shared& shared) {
    using Items = std::remove_const_t<typename Shared::element_type>;
    if constexpr (Way::reads) {
        Items items;
        way(items);
        shared = std::make_shared<const Items>(std::move(items));
    } else {
        static const Items none;
        way(shared ? *shared : none);
    }
}

template <class Way, class Shared>
void passStrokes(Way& way, Shared& shared) {
    const auto pass = [&way](auto& strokes) {
        auto& depths = strokes.areaDepths;
        way(strokes.points, strokes.lines, strokes.outlines, strokes.areas, depths.width, depths.height,
            depths.values, strokes.color, strokes.opacity);
    };
    if constexpr (Way::reads) {
        Strokes strokes;
        pass(strokes);
        shared = std::make_shared<const Strokes>(std::move(strokes));
    } else {
        pass(*shared);
    }
}

/// Null has no pixels.
template <class Way, class Shared>
void passColors(Way& way, Shared& shared) {
    std::uint32_t width = shared ? shared->width() : 0, height = shared ? shared->height() : 0;
    way(width, height);
    if (width == 0) return;
    if constexpr (Way::reads) {
        std::vector<glm::vec3> colors;
        std::vector<std::uint16_t> places;
        way(colors, places);
        shared = std::make_shared<const PixelColors>(width, height, std::move(colors), std::move(places));
    } else {
        way(shared->colors(), shared->places());
    }
}

/// By leaf; null: there are none.
template <class Way, class Shared>
void passLeafValues(Way& way, Shared& shared) {
    bool any = shared != nullptr;
    way(any);
    if (!any) return;
    if constexpr (Way::reads) {
        PointValues values{.codes = {}, .byLeaf = true};
        way(values.codes, values.complete);
        shared = std::make_shared<const PointValues>(std::move(values));
    } else {
        way(shared->codes, shared->complete);
    }
}

template <class Way, class Points>
void passPoints(Way& way, Points& points) {
    MOTE_CHECK(points.preview == nullptr);
    bool selects = points.selection != nullptr && points.selection->points > 0;
    way(points.layer, points.boxToEye, points.look, points.fraction, points.meanWeight, points.thinning,
        selects, points.leavesInView, points.pointsDrawn, points.share, points.clips);
    bool shaded = points.colors && points.colors->shade;
    way(shaded);
    if constexpr (Way::reads) {
        if (!selects) points.selection = std::make_shared<const PointSelection>();
        if (shaded) points.colors = PointColors{.values = nullptr, .shade = PointShade{}};
    }
    if (shaded) way(points.colors->map, *points.colors->shade);
}

template <class Way, class Field>
void passField(Way& way, Field& field) {
    auto& transfer = field.transfer;
    bool ofGrid = field.grid() != nullptr;
    way(field.layer, field.boxToEye, field.boxToLayer, transfer.opacity, transfer.opacityLength,
        transfer.fade, transfer.colorMap, transfer.colorRange, transfer.colors, transfer.span, field.clips,
        ofGrid);
    if (!ofGrid) {
        if constexpr (Way::reads) field.samples = DensityField{};
        auto& cells = std::get<DensityField>(field.samples);
        way(cells.strength);
        return passLeafValues(way, cells.values);
    }
    if constexpr (Way::reads) field.samples = CorrectedField{};
    auto& samples = std::get<CorrectedField>(field.samples);
    way(samples.bricks, samples.correction, samples.steepness, samples.gradient, samples.shades);
}

template <class Way, class Plan>
void passPlan(Way& way, Plan& plan) {
    auto& camera = plan.camera;
    way(plan.width, plan.height, camera.eye, camera.target, camera.up, camera.fovYDegrees,
        camera.orthographicHeight, plan.background, plan.nearDepth, plan.farDepth, plan.slabs, plan.sections,
        plan.samplesPerCell, plan.exact);
    passEach(way, plan.points, {}, [&](auto& points) { passPoints(way, points); });
    const TransferFunction nothing{.opacity = Curve::constant(0.0), .opacityLength = 1.0};
    passEach(way, plan.fields, {.layer = 0, .transfer = nothing, .samples = {}},
             [&](auto& field) { passField(way, field); });
    passShared(way, plan.dots);
    passEach(way, plan.fragments, {}, [&](auto& fragments) { passShared(way, fragments); });
    constexpr std::uint64_t pens = 2;  // of paths: their own, and their casing's
    passEach(
        way, plan.strokes, {}, [&](auto& strokes) { passStrokes(way, strokes); }, pens);
}

template <class Way, class Order>
void passOrder(Way& way, Order& order) {
    way(order.number, order.format, order.flatPoints);
    passPlan(way, order.plan);
    const auto passName = [&](auto& name) { way(name.file, name.digest, name.selection, name.parts); };
    passEach(way, order.pointSteps, {}, passName);
    passEach(way, order.fieldSteps, {}, passName);
    passEach(way, order.colors, {}, [&](auto& colors) { passColors(way, colors); });
}

}  // namespace

Bytes packOrder(const FrameOrder& order) {
    Packing packing;
    passOrder(packing, order);
    return packing.take();
}

FrameOrder unpackOrder(std::span<const std::byte> bytes) {
    Unpacking unpacking(bytes);
    FrameOrder order;
    passOrder(unpacking, order);
    MOTE_CHECK(unpacking.atEnd());
    return order;
}

}  // namespace mote::render
