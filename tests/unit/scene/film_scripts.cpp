// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/scene/film_scripts.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "protocol/base/json.h"
#include "protocol/scene/view.h"
#include "tests/support/any_selection.h"
#include "tests/views/view_generator.h"

namespace mote::test {
namespace {

void decorate(Random& random, proto::Layer& layer) {
    if (random.chance(0.4)) layer.set_opacity(random.unit());
    if (layer.has_ink()) layer.mutable_ink()->set_coherent(random.chance(0.3));
    if (!layer.has_stipple()) return;
    if (random.chance(0.2))
        layer.mutable_stipple()->set_image("views/picture");
    else if (random.chance(0.2))
        layer.mutable_stipple()->set_source("layers");
}

const SelectionShape anything{.columns = {{"x", -1e-3, 1e-3}, {"px", -2e5, 3e5}}, .ids = 100, .steps = 3};

void setUnitColor(Random& random, google::protobuf::RepeatedField<double>* color) {
    for (int i = 0; i < 3; ++i) color->Add(random.unit());
}

/// What layers of particles carry besides their style.
void addParts(Random& random, proto::Layer& layer) {
    if (random.chance(0.2)) {
        auto& colorBy = *layer.mutable_color_by();
        colorBy.set_column(random.oneOf({"x", "energy"}));
        colorBy.set_of_pixel(random.oneOf({"", "mean", "nearest"}));
        if (random.chance(0.3)) colorBy.set_color_map("magma");
        if (random.chance(0.6)) {
            colorBy.add_range(random.between(-2.0, 0.0));
            colorBy.add_range(random.between(0.1, 3.0));
        }
    }
    if (random.chance(0.2)) *layer.mutable_select() = toProto(anySelection(random, anything));
    if (random.chance(0.2)) {
        auto& highlight = *layer.mutable_highlight();
        *highlight.mutable_selection() = toProto(anySelection(random, anything));
        if (random.chance(0.5)) setUnitColor(random, highlight.mutable_color());
        if (random.chance(0.5)) highlight.set_size_pixels(random.between(0.5, 8.0));
        if (random.chance(0.5)) highlight.set_opacity(random.unit());
    }
    if (random.chance(0.2)) {
        for (auto count = random.below(4); count > 0; --count)
            layer.mutable_paths()->add_ids(random.below(9));
        if (random.chance(0.5)) setUnitColor(random, layer.mutable_paths()->mutable_color());
        if (random.chance(0.5)) layer.mutable_paths()->set_width(random.between(0.5, 8.0));
    }
}

void annotate(Random& random, proto::View& view) {
    if (random.chance(0.3)) {
        auto& annotations = *view.mutable_annotations();
        annotations.set_axes(random.chance(0.5));
        annotations.set_labels(random.chance(0.5));
        if (random.chance(0.5)) annotations.set_title("a title");
        if (random.chance(0.5)) annotations.set_font_points(random.between(5.0, 20.0));
        if (random.chance(0.5)) annotations.set_print_width(random.between(50.0, 200.0));
        if (random.chance(0.5)) setUnitColor(random, annotations.mutable_color());
    }
    if (random.chance(0.2)) {
        auto& named = *view.add_selections();
        named.set_name("some");
        *named.mutable_selection() = toProto(anySelection(random, anything));
        for (auto& layer : *view.mutable_layers()) {
            if (layer.has_select()) layer.mutable_select()->set_named("some");
        }
    }
}

/// The style of some other layer of the same kind.
void restyle(Random& random, std::uint64_t seed, proto::Layer& layer) {
    for (int tries = 0; tries < 40; ++tries) {
        const auto view = anyView(seed, random.below(100000));
        for (auto other : view.layers()) {
            if (other.kind_case() != layer.kind_case()) continue;
            other.set_dataset(layer.dataset());
            other.set_step(layer.step());
            if (other.has_select()) other.mutable_select()->clear_named();
            layer = other;
            return;
        }
    }
}

/// Fields of it set as the next keyframe may have them.
void change(Random& random, std::uint64_t seed, bool blend, proto::View& view) {
    const auto other = anyView(seed, random.below(100000));
    *view.mutable_background() = other.background();
    view.clear_camera();
    if (other.has_camera()) *view.mutable_camera() = other.camera();
    for (auto& layer : *view.mutable_layers()) {
        if (random.chance(0.5)) restyle(random, seed, layer);
        if (random.chance(0.3)) layer.set_opacity(random.unit());
        if (blend && (layer.has_particles() || layer.has_hybrid()))
            layer.set_step(static_cast<std::uint32_t>(random.below(3)));
    }
    if (view.layers_size() > 1 && random.chance(0.3)) view.mutable_layers()->RemoveLast();
    if (view.layers_size() < 3 && other.layers_size() > 0 && random.chance(0.4))
        *view.add_layers() = other.layers(0);
    if (other.has_annotations()) *view.mutable_annotations() = other.annotations();
    *view.mutable_selections() = other.selections();
    if (other.selections_size() > 0) return;
    for (auto& layer : *view.mutable_layers()) {
        if (layer.has_select()) layer.mutable_select()->clear_named();
    }
}

void keepFew(int most, proto::View& view) {
    while (view.layers_size() > most) view.mutable_layers()->RemoveLast();
}

void addKeyframe(double seconds, const Camera& camera, proto::Script& script) {
    auto& keyframe = *script.add_keyframes();
    keyframe.set_seconds(seconds);
    keyframe.mutable_view()->set_width(64);
    keyframe.mutable_view()->set_height(48);
    *keyframe.mutable_view()->mutable_camera() = toProto(camera);
}

glm::dvec3 someUp(Random& random) {
    return random.chance(0.5) ? glm::dvec3(0.0, 1.0, 0.0) : random.direction();
}

}  // namespace

proto::View anyView(std::uint64_t seed, std::uint64_t number) {
    Random random(seed ^ 0x5eed, number);
    while (true) {
        auto view = generatedView(seed, number);
        for (auto& layer : *view.mutable_layers()) decorate(random, layer);
        for (auto& layer : *view.mutable_layers()) {
            if (layer.has_particles()) addParts(random, layer);
        }
        annotate(random, view);
        if (random.chance(0.3)) view.set_scale(random.between(0.3, 3.0));
        if (parseView(view).ok()) return view;
    }
}

proto::Script anyKeyframes(std::uint64_t seed, std::uint64_t number) {
    Random random(seed, number);
    proto::Script script;
    const bool blend = random.chance(0.5);
    if (blend) script.set_between_steps("blend");
    auto view = anyView(seed, random.below(100000));
    keepFew(2, view);
    double seconds = random.between(-5.0, 5.0);
    for (auto count = 2 + random.below(4); count > 0; --count) {
        auto& keyframe = *script.add_keyframes();
        keyframe.set_seconds(seconds);
        if (random.chance(0.3)) view.set_scale(random.between(0.3, 3.0));
        if (!parseView(view).ok()) view.clear_scale();  // a length is too long for it
        *keyframe.mutable_view() = view;
        keyframe.set_easing(random.oneOf({"", "linear", "smooth"}));
        seconds += random.between(0.25, 3.0);
        change(random, seed, blend, view);
        keepFew(2, view);
    }
    return script;
}

proto::Script anyMoves(std::uint64_t seed, std::uint64_t number) {
    Random random(seed, number);
    proto::Script script;
    if (random.chance(0.5)) script.set_between_steps("blend");
    *script.mutable_view() = anyView(seed, random.below(100000));
    keepFew(4, *script.mutable_view());
    for (auto count = 1 + random.below(4); count > 0; --count) {
        auto& move = *script.add_moves();
        move.set_seconds(random.between(0.25, 3.0));
        move.set_easing(random.oneOf({"", "linear", "smooth"}));
        if (random.chance(0.5)) {
            move.mutable_turn()->set_degrees(random.between(-720.0, 720.0));
            const glm::dvec3 axis = random.direction();
            if (random.chance(0.5)) move.mutable_turn()->mutable_axis()->Assign(&axis.x, &axis.x + 3);
        }
        if (random.chance(0.3) && script.view().layers_size() > 0) {
            move.mutable_play_steps()->set_from(static_cast<std::uint32_t>(random.below(3)));
            move.mutable_play_steps()->set_to(static_cast<std::uint32_t>(random.below(3)));
        }
        if (random.chance(0.4)) move.mutable_zoom_to()->set_factor(random.magnitude(-3, 3));
        if (!move.has_turn() && !move.has_play_steps() && !move.has_zoom_to()) move.mutable_hold();
    }
    return script;
}

proto::Script anyCameraWay(Random& random, int keyframes) {
    proto::Script script;
    double seconds = 0.0;
    for (int i = 0; i < keyframes; ++i) {
        Camera camera;
        camera.target = 0.5 * random.direction();
        camera.eye = camera.target + random.between(1.5, 6.0) * random.direction();
        camera.up = someUp(random);
        camera.fovYDegrees = random.between(20.0, 60.0);
        addKeyframe(seconds, camera, script);
        seconds += random.between(0.5, 2.0);
    }
    return script;
}

proto::Script anyJourney(Random& random, int keyframes) {
    proto::Script script;
    double seconds = 0.0, around = 0.0;
    for (int i = 0; i < keyframes; ++i) {
        Camera camera;
        const double up = random.between(-0.3, 0.3);
        const glm::dvec3 side(std::cos(up) * std::sin(around), std::sin(up), std::cos(up) * std::cos(around));
        camera.target = 0.2 * random.direction();
        camera.eye = camera.target + random.between(3.2, 4.8) * side;
        camera.fovYDegrees = random.between(25.0, 45.0);
        addKeyframe(seconds, camera, script);
        around += random.between(0.5, 1.2);
        seconds += random.between(1.0, 3.0);
    }
    return script;
}

FilmDatasets datasetsFor(const proto::Script& script, int steps) {
    FilmDatasets datasets;
    for (const auto& name : datasetsOf(script)) datasets[name].steps = steps;
    return datasets;
}

proto::Script scriptOf(std::string_view json) {
    std::string text(json);
    std::replace(text.begin(), text.end(), '\'', '"');
    proto::Script script;
    const auto parsed = parseJson(text, script, "script");
    if (!parsed.ok()) throw std::invalid_argument(parsed.error().toString());
    return script;
}

Film filmOf(const proto::Script& script, int steps) {
    auto film = Film::create(script, datasetsFor(script, steps));
    if (!film.ok()) throw std::invalid_argument(film.error().toString());
    return *std::move(film);
}

Camera cameraAt(const Film& film, double seconds) {
    return parseView(film.at(seconds)).value().camera;
}

}  // namespace mote::test
