// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/views/random_styles.h"

#include <algorithm>
#include <optional>

#include "protocol/scene/fields/facts.h"
#include "tests/views/random_curves.h"

namespace mote::test {
namespace {

constexpr ValueRange shares{0.0, 1.0};

/// Pixels from 0.1 to 64, mostly of the size of points.
double anySize(Random& random) {
    if (random.chance(0.25)) return random.oneOf({0.1, 1.0, 1.001, 2.0, 7.0, 33.0, 64.0});
    return random.chance(0.7) ? random.between(0.5, 4.0) : random.between(0.25, 16.0);
}

const google::protobuf::FieldDescriptor& fieldOf(const google::protobuf::Message& message, int number) {
    return *message.GetDescriptor()->FindFieldByNumber(number);
}

/// Anything that the schema lets a number be; mostly no more than `usual`.
void setNumber(Random& random, google::protobuf::Message& message, int number, double usual) {
    const auto& field = fieldOf(message, number);
    const auto ends = endsOf(field).value();
    const double most = usual < ends.greatest && !random.chance(0.2) ? usual : ends.greatest;
    message.GetReflection()->SetDouble(&message, &field, random.between(ends.least, most));
}
void setNumber(Random& random, google::protobuf::Message& message, int number) {
    setNumber(random, message, number, endsOf(fieldOf(message, number)).value().greatest);
}

/// One of the words of the schema.
void setWord(Random& random, google::protobuf::Message& message, int number) {
    const auto& field = fieldOf(message, number);
    const auto& words = factsOf(field).one_of();
    const auto word = static_cast<int>(random.below(static_cast<std::uint64_t>(words.size())));
    message.GetReflection()->SetString(&message, &field, words[word]);
}
/// Or none.
void setAnyWord(Random& random, google::protobuf::Message& message, int number) {
    const auto& field = fieldOf(message, number);
    const auto& words = factsOf(field).one_of();
    const auto word = static_cast<int>(random.below(static_cast<std::uint64_t>(words.size()) + 1));
    message.GetReflection()->SetString(&message, &field, word == 0 ? "" : words[word - 1]);
}

void setVector(const glm::dvec3& vector, google::protobuf::RepeatedField<double>* field) {
    field->Assign(&vector.x, &vector.x + 3);
}

void setVolume(Random& random, proto::VolumeStyle& style) {
    if (random.chance(0.85)) {
        for (const auto& knot : anyKnots(random, shares)) {
            auto* const added = style.add_curve();
            added->set_density(knot.x);
            added->set_opacity(knot.y);
        }
    }
    if (random.chance(0.6)) style.set_color_map(anyColorMap(random));
}

void setPoints(Random& random, proto::PointsStyle& style) {
    if (random.chance(0.6)) style.set_linked(random.chance(0.3));
    if (style.has_linked() && !style.linked()) {
        for (const auto& knot : anyKnots(random, shares)) {
            auto* const added = style.add_curve();
            added->set_density(knot.x);
            added->set_fraction(knot.y);
        }
    }
    if (random.chance(0.5)) style.set_opacity(anyShare(random));
    if (random.chance(0.7)) style.set_size_pixels(anySize(random));
    if (random.chance(0.6)) setAnyColor(random, style.mutable_color());
}

void setLight(Random& random, bool mayShadow, proto::Light& light) {
    if (random.chance(0.6)) {
        const double length = random.magnitude(-4, 4);
        setVector(length * random.direction(), light.mutable_direction());
    }
    light.set_fixed(random.chance(0.3));
    if (random.chance(0.5)) light.set_ambient(anyShare(random));
    if (random.chance(0.5)) light.set_diffuse(anyShare(random));
    if (random.chance(0.5)) light.set_specular(anyShare(random));
    light.set_shadow(mayShadow && random.chance(0.2));
}

void setCurve(Random& random, const ValueRange& range, proto::HybridStyle& style) {
    if (random.chance(0.15)) return;
    const bool colored = random.chance(0.3);
    const double wider = random.chance(0.1) ? 0.5 * (range.high - range.low) : 0.0;
    for (const auto& knot : anyKnots(random, {range.low - wider, range.high + wider})) {
        auto* const added = style.add_curve();
        added->set_value(knot.x);
        added->set_opacity(knot.y);
        if (colored) setAnyColor(random, added->mutable_color());
    }
    if (!colored && random.chance(0.5)) style.set_color_map(anyColorMap(random));
    if (!random.chance(0.2)) return;
    const double low = random.between(range.low, range.high);
    style.add_color_range(low);
    style.add_color_range(low + random.magnitude(-6, 1) * (range.high - range.low));
}

void setRepresentation(Random& random, const DatasetTraits& data, proto::HybridStyle& style) {
    const auto name = random.oneOf({"", "volume", "residual", "points"});
    using enum HybridRepresentation;
    const bool has = (name[0] != 'r' || data.parts == residual) && (name[0] != 'p' || data.parts == points);
    style.set_representation(has ? name : "");
}

/// All that a style says of a hybrid volume's points, but for their being drawn at all.
void setHybridPoints(Random& random, proto::HybridStyle& style) {
    setAnyWord(random, style, style.kPointShapeFieldNumber);
    if (random.chance(0.4)) style.set_point_opacity(anyShare(random));
}

void setPlanes(Random& random, const Bounds& bounds, ClipPlanes& planes) {
    if (!random.chance(0.35)) return;
    const glm::dvec3 size = bounds.size();
    for (auto count = 1 + random.below(random.chance(0.2) ? 6 : 2); count > 0; --count) {
        const double length = random.magnitude(-3, 3);
        const glm::dvec3 normal = length * random.direction();
        // Through a place within the box mostly; beyond it all stays, or nothing.
        const double x = random.unit(), y = random.unit(), z = random.unit();
        glm::dvec3 place = bounds.min + size * glm::dvec3(x, y, z);
        if (random.chance(0.15)) place += 2.0 * random.sign() * size;
        auto* const plane = planes.Add();
        setVector(normal, plane->mutable_normal());
        plane->set_distance(normal.x * place.x + normal.y * place.y + normal.z * place.z);
    }
}

std::optional<proto::ClipBox> anyClipBox(Random& random, const Bounds& bounds) {
    if (!random.chance(0.25)) return std::nullopt;
    glm::dvec3 min = bounds.min, max = bounds.max;
    const glm::dvec3 size = bounds.size();
    for (int axis = 0; axis < 3; ++axis) {
        if (random.chance(0.4)) continue;  // exactly at the volume's own sides
        min[axis] = bounds.min[axis] + size[axis] * random.between(-0.25, random.chance(0.1) ? 2.0 : 0.6);
        max[axis] = min[axis] + size[axis] * random.magnitude(-4, 1);
    }
    proto::ClipBox box;
    setVector(min, box.mutable_min());
    setVector(max, box.mutable_max());
    return box;
}

}  // namespace

proto::ParticlesStyle anyParticlesStyle(Random& random) {
    proto::ParticlesStyle style;
    setVolume(random, *style.mutable_volume());
    setPoints(random, *style.mutable_points());
    // Some leave curves and colours to the plot. By numbers of its own: all else stays as it would be.
    Random own(style.ByteSizeLong(), 11);
    if (!own.chance(0.25)) return style;
    style.mutable_volume()->clear_curve();
    style.mutable_points()->clear_curve();
    style.mutable_points()->clear_linked();
    style.mutable_points()->clear_color();
    if (own.chance(0.5)) style.mutable_points()->clear_opacity();
    return style;
}

proto::HybridStyle anyHybridStyle(Random& random, const DatasetTraits& data) {
    proto::HybridStyle style;
    setRepresentation(random, data, style);
    setCurve(random, data.range, style);
    setHybridPoints(random, style);
    if (random.chance(0.6)) setLight(random, false, *style.mutable_light());
    setPlanes(random, data.bounds, *style.mutable_clip_planes());
    if (const auto box = anyClipBox(random, data.bounds)) *style.mutable_clip_box() = *box;
    // By numbers of its own: all else stays as it would be.
    Random own(style.ByteSizeLong(), 7);
    if (own.chance(0.2)) style.set_silhouettes(anyShare(own));
    if (own.chance(0.2)) setWord(own, style, style.kShowsFieldNumber);
    if (!style.shows().empty() && own.chance(0.7))
        style.set_isovalue(own.between(data.range.low, data.range.high));
    if (style.shows().empty() && own.chance(0.3)) style.set_gradient_opacity(anyShare(own));
    return style;
}

proto::Clip anyClip(Random& random, const Bounds& bounds) {
    proto::Clip clip;
    setPlanes(random, bounds, *clip.mutable_planes());
    if (const auto box = anyClipBox(random, bounds)) *clip.mutable_box() = *box;
    return clip;
}

proto::StippleStyle anyStippleStyle(Random& random) {
    proto::StippleStyle style;
    if (random.chance(0.5)) style.set_spacing_pixels(random.chance(0.2) ? 0.5 : random.between(1.0, 1000.0));
    if (random.chance(0.7)) style.set_dot_pixels(anySize(random));
    if (random.chance(0.4)) style.set_least_dot_pixels(anySize(random));
    if (random.chance(0.6)) setAnyColor(random, style.mutable_color());
    if (random.chance(0.3)) setLight(random, true, *style.mutable_light());
    if (random.chance(0.3)) setNumber(random, style, style.kJitterFieldNumber);
    style.set_soft(random.chance(0.3));
    if (random.chance(0.3)) style.set_gamma(random.between(0.0625, 20.0));
    style.set_invert(random.chance(0.3));
    if (random.chance(0.7)) style.set_opacity(anyShare(random));
    style.set_see_through(random.chance(0.3));
    setAnyWord(random, style, style.kValueFieldNumber);
    if (random.chance(0.3)) style.set_color_map(anyColorMap(random));
    // By numbers of its own: all else stays as it would be.
    Random own(style.ByteSizeLong(), 5);
    if (own.chance(0.3)) setWord(own, style, style.kDenseFieldNumber);
    return style;
}

void addWash(Random& random, proto::InkStyle& style) {
    auto& wash = *style.mutable_wash();
    if (random.chance(0.5)) setAnyColor(random, wash.mutable_color());
    for (const int field : {wash.kStrengthFieldNumber, wash.kTonesFieldNumber, wash.kEdgesFieldNumber,
                            wash.kGranulationFieldNumber})
        if (random.chance(0.4)) setNumber(random, wash, field);
    if (random.chance(0.4)) setNumber(random, wash, wash.kBleedFieldNumber, 12.0);
}

/// Dabs in a box as plots have it, or near the middle of data that are smaller or larger.
void addRegions(Random& random, proto::InkStyle& style) {
    for (auto count = 1 + random.below(3); count > 0; --count) {
        auto& region = *style.add_regions();
        const double size = random.oneOf({0.1, 1.0, 100.0});
        for (auto dabs = 1 + random.below(6); dabs > 0; --dabs) {
            for (int i = 0; i < 3; ++i) region.add_dabs(size * random.between(-1.0, 1.0));
        }
        region.set_radius(size * random.between(0.05, 1.0));
        region.set_whole(random.chance(0.4));
        setAnyWord(random, region, region.kFillFieldNumber);
        if (random.chance(0.4)) region.set_direction_degrees(random.between(-180.0, 180.0));
    }
}

proto::InkStyle anyInkStyle(Random& random) {
    proto::InkStyle style;
    auto& silhouettes = *style.mutable_silhouettes();
    setAnyWord(random, silhouettes, silhouettes.kModeFieldNumber);
    if (random.chance(0.5)) silhouettes.set_importance(anyShare(random));
    if (random.chance(0.5)) setNumber(random, silhouettes, silhouettes.kWidthFieldNumber, 4.0);
    if (random.chance(0.3)) setNumber(random, silhouettes, silhouettes.kCreaseDegreesFieldNumber);
    silhouettes.set_omit(random.chance(0.2));
    auto& hatch = *style.mutable_hatch();
    if (random.chance(0.5)) hatch.set_strength(anyShare(random));
    if (random.chance(0.5)) setNumber(random, hatch, hatch.kSpacingFieldNumber, 8.0);
    if (random.chance(0.5)) setNumber(random, hatch, hatch.kWidthFieldNumber, 4.0);
    if (random.chance(0.3)) setWord(random, hatch, hatch.kSegmentsFieldNumber);
    if (random.chance(0.3)) {
        if (random.chance(0.7)) style.mutable_ink()->set_strength(anyShare(random));
        if (random.chance(0.7)) style.mutable_ink()->set_complexity(anyShare(random));
    }
    if (random.chance(0.2)) style.set_occlusion(anyShare(random));
    if (random.chance(0.5)) setNumber(random, style, style.kReadingFieldNumber, 16.0);
    if (random.chance(0.5)) setLight(random, true, *style.mutable_light());
    if (random.chance(0.4)) setAnyColor(random, style.mutable_color());
    if (random.chance(0.2)) setWord(random, style, style.kShowFieldNumber);
    if (random.chance(0.3)) setNumber(random, style, style.kWaverFieldNumber);
    style.set_taper(random.chance(0.3));
    // By numbers of its own: all else stays as it would be.
    Random own(style.ByteSizeLong(), 7);
    silhouettes.set_suggestive(own.chance(0.3));
    if (own.chance(0.3)) addWash(own, style);
    if (own.chance(0.3)) addRegions(own, style);
    return style;
}

proto::InkStyle anyInkStyle(Random& random, const DatasetTraits& data) {
    auto style = anyInkStyle(random);
    if (random.chance(0.3)) return style;
    for (const auto& knot : anyKnots(random, data.range)) {
        auto* const added = style.add_curve();
        added->set_value(knot.x);
        added->set_opacity(knot.y);
    }
    return style;
}

proto::MeshStyle anyMeshStyle(Random& random) {
    proto::MeshStyle style;
    if (random.chance(0.6)) setAnyColor(random, style.mutable_color());
    if (random.chance(0.5)) style.set_opacity(anyShare(random));
    if (random.chance(0.6)) setLight(random, true, *style.mutable_light());
    style.set_wire(random.chance(0.2));
    // By numbers of its own: all else stays as it would be.
    Random own(style.ByteSizeLong(), 3);
    if (style.wire() && own.chance(0.5)) style.set_wire_width(std::max(0.25, anySize(own)));
    return style;
}

}  // namespace mote::test
