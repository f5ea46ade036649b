// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/views/out_of_range.h"

#include <fmt/format.h>

#include <functional>
#include <limits>
#include <vector>

#include "protocol/scene/fields/facts.h"
#include "protocol/scene/view.h"

namespace mote::test {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

constexpr double infinity = std::numeric_limits<double>::infinity();

/// One number in a message: a field, or an element of one.
struct Place {
    Message* message;
    const FieldDescriptor* field;
    int element;  ///< -1: the field is one number
    std::string path;

    void set(double value) const {
        const Reflection* const reflection = message->GetReflection();
        if (element < 0) return reflection->SetDouble(message, field, value);
        reflection->SetRepeatedDouble(message, field, element, value);
    }
};

void collectField(Message* message, const FieldDescriptor* field, const std::string& path,
                  std::vector<Place>& places);

void collect(Message* message, const std::string& path, std::vector<Place>& places) {
    std::vector<const FieldDescriptor*> fields;
    message->GetReflection()->ListFields(*message, &fields);
    for (const auto* const field : fields) collectField(message, field, path + '.' + field->name(), places);
}

void collectField(Message* message, const FieldDescriptor* field, const std::string& path,
                  std::vector<Place>& places) {
    const Reflection* const reflection = message->GetReflection();
    const bool number = field->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE;
    const bool part = field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE;
    if (!field->is_repeated()) {
        if (number) places.push_back({message, field, -1, path});
        if (part) collect(reflection->MutableMessage(message, field), path, places);
        return;
    }
    for (int i = 0; i < reflection->FieldSize(*message, field); ++i) {
        const auto at = fmt::format("{}[{}]", path, i);
        if (number) places.push_back({message, field, i, at});
        if (part) collect(reflection->MutableRepeatedMessage(message, field, i), at, places);
    }
}

/// A little or far beyond one of two ends.
double beyond(Random& random, const Ends& ends) {
    const double width = ends.greatest - ends.least;
    const double off = width * random.oneOf({1e-9, 0.5, 1e9});
    return random.chance(0.5) ? ends.greatest + off : ends.least - off;
}

proto::Layer& layerOf(proto::View& view) {
    if (view.layers().empty()) {
        view.add_layers()->set_dataset("views/beam-0");
        view.mutable_layers(0)->mutable_particles();
    }
    return *view.mutable_layers(0);
}

proto::HybridStyle& hybridOf(proto::View& view) {
    return *layerOf(view).mutable_hybrid();
}

void makeWrongVector(Random& random, google::protobuf::RepeatedField<double>* field, int right) {
    field->Resize(right, 0.5);
    if (random.chance(0.5)) {
        field->RemoveLast();
    } else {
        field->Add(0.5);
    }
}

using Spoil = std::function<void(Random&, proto::View&)>;

/// What is wrong beside numbers beyond their ends.
const std::vector<std::pair<const char*, Spoil>>& spoils() {
    static const std::vector<std::pair<const char*, Spoil>> all{
        {"width 0", [](Random&, proto::View& view) { view.set_width(0); }},
        {"height 0", [](Random&, proto::View& view) { view.set_height(0); }},
        {"wide",
         [](Random& r, proto::View& v) {
             v.set_width(r.oneOf({16385U, 1U << 20, ~0U}));
         }},
        {"high",
         [](Random& r, proto::View& v) {
             v.set_height(r.oneOf({16385U, 1U << 31, ~0U}));
         }},
        {"large", [](Random&, proto::View& view) { view.set_width(8193), view.set_height(4097); }},
        {"nine layers",
         [](Random&, proto::View& view) {
             const auto one = layerOf(view);
             while (view.layers_size() <= View::maxLayers) *view.add_layers() = one;
         }},
        {"no dataset", [](Random&, proto::View& view) { layerOf(view).clear_dataset(); }},
        {"no kind", [](Random&, proto::View& view) { layerOf(view).clear_kind(); }},
        {"background", [](Random& r, proto::View& v) { makeWrongVector(r, v.mutable_background(), 3); }},
        {"transform",
         [](Random& r, proto::View& v) { makeWrongVector(r, layerOf(v).mutable_transform(), 16); }},
        {"eye", [](Random& r, proto::View& v) { makeWrongVector(r, v.mutable_camera()->mutable_eye(), 3); }},
        {"eye is target",
         [](Random&, proto::View& view) {
             auto& camera = *view.mutable_camera();
             camera.mutable_eye()->Resize(3, 1.0);
             *camera.mutable_target() = camera.eye();
         }},
        {"singular",
         [](Random& r, proto::View& view) {
             auto& layer = layerOf(view);
             layer.clear_transform();
             for (int i = 0; i < 16; ++i) layer.add_transform(i == 15 ? 1.0 : 0.0);
             // One axis is left flat, all of it too small, or too large.
             const double scale = r.oneOf({0.0, 1e-7, 1e7});
             for (int i = 0; i < 3; ++i) layer.set_transform(5 * i, scale == 0.0 && i < 2 ? 1.0 : scale);
         }},
        {"projective",
         [](Random&, proto::View& view) {
             auto& layer = layerOf(view);
             layer.clear_transform();
             for (int i = 0; i < 16; ++i) layer.add_transform(i % 5 == 0 ? 1.0 : 0.0);
             layer.set_transform(12, 1e-9);
         }},
        {"descending knots",
         [](Random&, proto::View& view) {
             auto& volume = *layerOf(view).mutable_particles()->mutable_volume();
             volume.add_curve()->set_density(1.0);
             volume.add_curve()->set_density(0.999999);
         }},
        {"257 knots",
         [](Random&, proto::View& view) {
             auto& volume = *layerOf(view).mutable_particles()->mutable_volume();
             while (volume.curve_size() <= 256) volume.add_curve()->set_density(1.0);
         }},
        {"linked curve",
         [](Random&, proto::View& view) {
             auto& points = *layerOf(view).mutable_particles()->mutable_points();
             points.clear_linked();
             points.add_curve();
         }},
        {"unlinked without a curve",
         [](Random&, proto::View& view) {
             auto& points = *layerOf(view).mutable_particles()->mutable_points();
             points.set_linked(false);
             points.clear_curve();
         }},
        {"color map", [](Random&, proto::View& view) { hybridOf(view).set_color_map("Inferno"); }},
        {"representation", [](Random&, proto::View& view) { hybridOf(view).set_representation("best"); }},
        {"point shape", [](Random&, proto::View& view) { hybridOf(view).set_point_shape("Disc"); }},
        {"some colors",
         [](Random&, proto::View& view) {
             auto& style = hybridOf(view);
             style.clear_curve();
             style.add_curve()->mutable_color()->Resize(3, 0.5);
             style.add_curve();
         }},
        {"empty color range",
         [](Random&, proto::View& view) {
             hybridOf(view).clear_color_range();
             hybridOf(view).mutable_color_range()->Resize(2, 1.0);
         }},
        {"seven planes",
         [](Random&, proto::View& view) {
             auto& style = hybridOf(view);
             while (style.clip_planes_size() <= 6) style.add_clip_planes()->mutable_normal()->Resize(3, 1.0);
         }},
        {"plane without direction",
         [](Random&, proto::View& view) {
             hybridOf(view).clear_clip_planes();
             hybridOf(view).add_clip_planes()->mutable_normal()->Resize(3, 0.0);
         }},
        {"flat box",
         [](Random&, proto::View& view) {
             auto& box = *hybridOf(view).mutable_clip_box();
             box.mutable_min()->Resize(3, 0.0);
             *box.mutable_max() = box.min();
         }},
        {"shadow", [](Random&, proto::View& v) { hybridOf(v).mutable_light()->set_shadow(true); }},
        {"light without direction",
         [](Random&, proto::View& view) {
             hybridOf(view).mutable_light()->clear_direction();
             hybridOf(view).mutable_light()->mutable_direction()->Resize(3, 0.0);
         }},
        {"stipple value",
         [](Random&, proto::View& view) { layerOf(view).mutable_stipple()->set_value("w"); }},
        {"stipple source",
         [](Random&, proto::View& view) { layerOf(view).mutable_stipple()->set_source("layer"); }},
    };
    return all;
}

}  // namespace

Fault withoutANumber(Random& random, const proto::View& view) {
    Fault fault{{}, view};
    if (fault.view.background().empty()) fault.view.mutable_background()->Resize(3, 0.5);
    std::vector<Place> places;
    collect(&fault.view, {}, places);
    const Place& place = places[random.below(places.size())];
    const double value = random.oneOf({std::numeric_limits<double>::quiet_NaN(), infinity, -infinity});
    place.set(value);
    fault.what = fmt::format("{} = {}", place.path, value);
    return fault;
}

Fault beyondItsEnds(Random& random, const proto::View& view) {
    Fault fault{{}, view};
    if (random.chance(0.5)) {
        const auto& [what, spoil] = spoils()[random.below(spoils().size())];
        spoil(random, fault.view);
        fault.what = what;
        return fault;
    }
    if (fault.view.background().empty()) fault.view.mutable_background()->Resize(3, 0.5);
    std::vector<Place> places;
    collect(&fault.view, {}, places);
    // What particles have numbers of may be any.
    std::erase_if(places, [](const Place& one) { return !endsOf(*one.field); });
    const Place& place = places[random.below(places.size())];
    const double value = beyond(random, *endsOf(*place.field));
    place.set(value);
    fault.what = fmt::format("{} = {}", place.path, value);
    return fault;
}

}  // namespace mote::test
