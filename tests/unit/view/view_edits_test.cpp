// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the user changes of a loaded view is changed, and nothing else.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "client/view/camera_control.h"
#include "client/view/layers/handles.h"
#include "client/view/layers/hybrid_editor.h"
#include "client/view/layers/ink_editor.h"
#include "client/view/layers/mesh_editor.h"
#include "client/view/layers/particles_editor.h"
#include "client/view/layers/stipple_editor.h"
#include "client/view/view_model.h"
#include "protocol/base/json.h"
#include "protocol/scene/clip.h"
#include "protocol/scene/view.h"
#include "tests/unit/view/panel_hand.h"
#include "tests/views/view_generator.h"

namespace mote::client {
namespace {

using test::generatedView;
using test::Random;
using testing::IsSubsetOf;
using Fields = std::set<std::string>;

/// Loads a view as the viewer does, its dataset described.
void load(const proto::View& view, ViewModel& model) {
    const auto loaded = model.load(view);
    ASSERT_TRUE(loaded.ok()) << loaded.error().toString();
    if (!view.layers().empty()) model.setDataset(view.layers(0).dataset(), manifestFor(view.layers(0)));
}

template <class Editor>
auto& controls(ViewModel& model) {
    return dynamic_cast<Editor&>(model.editor()).controls;
}

struct Edit {
    const char* field;  // that it changes, and no other
    proto::Layer::KindCase kind;
    std::function<void(ViewModel&)> make;
};

float other(float value) {
    return value > 0.5F ? 0.25F : 0.75F;
}

std::string otherName(const std::string& name) {
    return name == "plasma" ? "viridis" : "plasma";
}

template <class Editor, class Member>
std::function<void(ViewModel&)> moved(Member member) {
    return [member](ViewModel& model) {
        auto& value = controls<Editor>(model).*member;
        value = other(value);
    };
}

const std::vector<Edit>& edits() {
    using P = ParticlesControls;
    constexpr auto particles = proto::Layer::kParticles;
    static const std::vector<Edit> all{
        {"particles.points.opacity", particles, moved<ParticlesEditor>(&P::pointOpacity)},
        {"particles.points.size_pixels", particles, moved<ParticlesEditor>(&P::pointSize)},
        {"particles.points.color", particles,
         [](ViewModel& model) {
             auto& color = controls<ParticlesEditor>(model).pointColor;
             color[1] = other(color[1]);
         }},
        {"particles.volume.color_map", particles, [](ViewModel& model) {
             auto& map = controls<ParticlesEditor>(model).colorMap;
             map = otherName(map);
         }}};
    return all;
}

/// The field or, where the view had nothing of the message that holds it, that message.
bool isWithin(const std::string& changed, const std::string& field) {
    return changed == field || (field.starts_with(changed) && field[changed.size()] == '.');
}

/// Edits views of a kind of layer, 25 of them: they change by that alone.
void expectChanged(const std::string& field, proto::Layer::KindCase kind,
                   const std::function<void(ViewModel&)>& make) {
    int made = 0;
    for (std::uint64_t i = 0; made < 25; ++i) {
        ASSERT_LT(i, 100'000U) << "no views of the kind: " << field;
        const auto view = generatedView(41, i);
        if (view.layers().empty() || view.layers(0).kind_case() != kind) continue;
        ViewModel model;
        load(view, model);
        make(model);
        const auto changed = changedFields(view, model.edited());
        ASSERT_EQ(changed.size(), 1U) << field << " of view " << i << testing::PrintToString(changed);
        EXPECT_TRUE(isWithin(*changed.begin(), "layers[0]." + field)) << *changed.begin() << " for " << field;
        EXPECT_TRUE(parseView(model.view(64, 64)).ok()) << field << " of view " << i;
        ++made;
    }
}

TEST(ViewEdits, ChangeTheirFieldAlone) {
    for (const auto& edit : edits()) expectChanged(edit.field, edit.kind, edit.make);
}

TEST(ViewEdits, OfStylesThatAreMessagesChangeTheirFieldAlone) {
    expectChanged("stipple.spacing_pixels", proto::Layer::kStipple, [](ViewModel& model) {
        auto& style = dynamic_cast<StippleEditor&>(model.editor()).style;
        style.set_spacing_pixels(style.spacing_pixels() == 7.0 ? 8.0 : 7.0);
    });
    expectChanged("hybrid.representation", proto::Layer::kHybrid, [](ViewModel& model) {
        auto& style = controls<HybridEditor>(model).rest;
        style.set_representation(style.representation() == "volume" ? "points" : "volume");
    });
    expectChanged("hybrid.light.ambient", proto::Layer::kHybrid, [](ViewModel& model) {
        auto& light = *controls<HybridEditor>(model).rest.mutable_light();
        light.set_ambient(light.ambient() == 0.5 ? 0.25 : 0.5);
    });
    expectChanged("mesh.light.shadow", proto::Layer::kMesh, [](ViewModel& model) {
        auto& light = *dynamic_cast<MeshEditor&>(model.editor()).style.mutable_light();
        light.set_shadow(!light.shadow());
    });
    expectChanged("ink.hatch.spacing", proto::Layer::kInk, [](ViewModel& model) {
        auto& hatch = *dynamic_cast<InkEditor&>(model.editor()).style.mutable_hatch();
        hatch.set_spacing(hatch.spacing() == 4.5 ? 5.0 : 4.5);
    });
}

TEST(ViewEdits, TakenBackLeaveTheViewAsItWas) {
    for (std::uint64_t i = 0; i < 300; ++i) {
        const auto view = generatedView(42, i);
        if (view.layers().empty() || !view.layers(0).has_hybrid()) continue;
        ViewModel model;
        load(view, model);
        auto& style = controls<HybridEditor>(model).rest;
        const auto before = style;
        style.mutable_light()->set_ambient(style.light().ambient() == 0.5 ? 0.25 : 0.5);
        EXPECT_NE(toJson(model.edited()), toJson(view));
        style = before;
        EXPECT_EQ(toJson(model.edited()), toJson(view));
    }
}

proto::View viewOf(const std::string& layer, const std::string& more = "") {
    proto::View view;
    const auto text =
        fmt::format(R"({{"width": 64, "height": 48, {} "layers": [{{"dataset": "a/b", {}}}]}})", more, layer);
    const auto status = parseJson(text, view, "test");
    EXPECT_TRUE(status.ok()) << status.error().toString();
    return view;
}

TEST(ViewEdits, OfACameraLeaveWhatItDoesNotSay) {
    auto view =
        viewOf(R"("particles": {})", R"("camera": {"eye": [0, 0, 4.000000000001], "target": [0, 0, 0]},)");
    ViewModel model;
    load(view, model);
    model.setCamera(dolly(model.camera(1.0), 1.0, model.camera(1.0).target));
    EXPECT_EQ(changedFields(view, model.edited()), Fields{"camera.eye"});
    model.setCamera(toggleProjection(model.camera(1.0)));
    EXPECT_EQ(changedFields(view, model.edited()), (Fields{"camera.eye", "camera.orthographic_height"}));
    model.fit();
    EXPECT_EQ(changedFields(view, model.edited()), Fields{"camera"});
    EXPECT_TRUE(model.view(64, 48).has_camera());
    EXPECT_FALSE(model.asked(64, 48).has_camera());
}

TEST(ViewEdits, OfClipPlanesLeaveTheOthersAlone) {
    const auto view = viewOf(R"("hybrid": {"clipPlanes": [{"normal": [0, 3, 4], "distance": 0.001},
        {"normal": [1, 2, 2], "distance": 101325.001}]}, "clip": {"planes": [{"normal": [0, 0, 7]}]})");
    ViewModel model;
    load(view, model);
    auto clip = model.clip();
    ASSERT_EQ(clip.planes_size(), 3);  // of the layer, and of its style
    clip.mutable_planes(2)->set_distance(15.0);
    ASSERT_TRUE(model.setClip(clip).ok());
    const auto edited = model.edited();
    EXPECT_EQ(changedFields(view, edited),
              (Fields{"layers[0].hybrid.clip_planes", "layers[0].clip.planes"}));  // all are the layer's
    EXPECT_TRUE(edited.layers(0).hybrid().clip_planes().empty());
    EXPECT_EQ(toJson(edited.layers(0).clip()), toJson(clip));
    clip.mutable_planes(0)->clear_normal();
    EXPECT_FALSE(model.setClip(clip).ok());
    EXPECT_EQ(toJson(model.edited()), toJson(edited));
    EXPECT_TRUE(model.setClip({}).ok());
    EXPECT_FALSE(model.edited().layers(0).has_clip());
}

TEST(ViewEdits, OfPlanesBesideAClipMakeOneOfAll) {
    const auto view = viewOf(R"("hybrid": {}, "clipPlanes": [{"normal": [0, 0, 1], "distance": 2}],
        "clipBox": {"min": [0, 0, 0], "max": [1, 1, 1]}, "clip": {"planes": [{"normal": [0, 1, 0]}]})");
    ViewModel model;
    load(view, model);
    EXPECT_EQ(changedFields(view, model.edited()), Fields{});
    auto clip = model.clip();
    ASSERT_EQ(clip.planes_size(), 2);
    EXPECT_TRUE(clip.has_box());
    clip.mutable_planes(1)->set_distance(3.0);
    ASSERT_TRUE(model.setClip(clip).ok());
    const auto edited = model.edited().layers(0);
    EXPECT_EQ(toJson(edited.clip()), toJson(clip));
    EXPECT_TRUE(edited.clip_planes().empty());
    EXPECT_FALSE(edited.has_clip_box());
}

TEST(ViewEdits, APlaneCutsAwayTheHalfBeforeTheEye) {
    proto::Clip clip;
    const Bounds box{glm::dvec3(0.0), {40.0, 20.0, 20.0}};
    ASSERT_TRUE(cutBeforeMiddle(clip, box, {20.0, 10.0, 100.0}));
    const auto stays = halfSpacesOf(parseClip(clip).value());
    EXPECT_FALSE(inAll(stays, {20.0, 10.0, 11.0}));
    EXPECT_TRUE(inAll(stays, {20.0, 10.0, 9.0}));
    EXPECT_FALSE(cutBeforeMiddle(clip, box, box.center()));  // no direction
    for (int i = 0; i < 20; ++i) cutBeforeMiddle(clip, box, {20.0, 10.0, 100.0});
    EXPECT_EQ(clip.planes_size(), mostClipPlanes);
    setClipBox(clip, clipBoxOf(clip, {glm::dvec3(5.0, -3.0, 1000.0), glm::dvec3(5.0, -3.0, 1000.0)}));
    EXPECT_TRUE(parseClip(clip).ok());  // a flat dataset has a box too
}

TEST(ViewEdits, APlacementIsTheTransformThatItCameOf) {
    test::Random random(35);
    for (int i = 0; i < 200; ++i) {
        Placement placement;
        for (int axis = 0; axis < 3; ++axis) {
            placement.shift[axis] = random.between(-5.0, 5.0);
            placement.turn[axis] =
                i % 10 == 0 ? 90.0 * static_cast<double>(random.below(4)) : random.between(-180.0, 180.0);
            placement.stretch[axis] = random.between(0.1, 3.0) * (random.chance(0.3) ? -1.0 : 1.0);
        }
        const auto transform = placement.transform();
        const auto again = Placement::of(transform);
        ASSERT_TRUE(again.has_value());
        for (int column = 0; column < 4; ++column)
            for (int row = 0; row < 4; ++row)
                EXPECT_NEAR(again->transform()[column][row], transform[column][row], 1e-9);
    }
    glm::dmat4 oblique(1.0);
    oblique[1][0] = 0.3;
    EXPECT_FALSE(Placement::of(oblique).has_value());
}

TEST(ViewEdits, OfAKnotLeaveTheOthersAlone) {
    const auto view = viewOf(R"("hybrid": {"curve": [{"value": 0.1, "color": [0.1, 0.2, 0.3]},
        {"value": 101325.001, "opacity": 0.3, "color": [0.7, 0.7, 0.7]},
        {"value": 101325.002, "opacity": 0.1, "color": [1, 0.1, 0.3]}]})");
    ViewModel model;
    load(view, model);
    auto& curve = controls<HybridEditor>(model).curve;
    curve.move(1, {101325.001, 0.5});
    EXPECT_EQ(changedFields(view, model.edited()), Fields{"layers[0].hybrid.curve[1].opacity"});
    curve.insert({50000.0, 0.2});
    const auto edited = model.edited().layers(0).hybrid();
    ASSERT_EQ(edited.curve_size(), 4);
    for (const auto& [now, then] : {std::pair{0, 0}, {3, 2}})
        EXPECT_EQ(toJson(edited.curve(now)), toJson(view.layers(0).hybrid().curve(then)));
}

TEST(ViewEdits, OfASelectionThatALayerHoldsItselfStayInTheLayer) {
    const auto view = viewOf(R"("particles": {}, "select": {"density": {"max": 0.4}},
        "highlight": {"selection": {"ranges": [{"column": "x", "min": 101325.001, "max": 101325.002}]}})");
    ViewModel model;
    load(view, model);
    ASSERT_EQ(model.numbers.selections().size(), 2);
    auto selection = model.numbers.selections()[0].selection();
    selection.mutable_ranges(0)->set_min(3.0);
    ASSERT_TRUE(model.numbers.replace(0, selection).ok());
    EXPECT_EQ(changedFields(view, model.edited()), Fields{"layers[0].highlight.selection.ranges[0].min"});
    model.numbers.highlight("");  // it is still in the list
    const auto edited = model.edited();
    EXPECT_FALSE(edited.layers(0).has_highlight());
    ASSERT_EQ(edited.selections_size(), 1);
    EXPECT_EQ(edited.selections(0).selection().ranges(0).min(), 3.0);
    EXPECT_EQ(edited.layers(0).select().density().max(), 0.4);
}

TEST(ViewEdits, AStepThatIsNotThereIsKeptUntilAnotherIsChosen) {
    const auto view = viewOf(R"("particles": {}, "step": 7, "towards": {"step": 8, "share": 0.5})");
    ViewModel model;
    load(view, model);
    EXPECT_EQ(model.steps(), 3);
    EXPECT_EQ(toJson(model.edited()), toJson(view));
    EXPECT_EQ(model.asked(64, 48).layers(0).step(), 7U);
    model.setStep(2);
    EXPECT_EQ(changedFields(view, model.edited()), (Fields{"layers[0].step", "layers[0].towards"}));
}

TEST(ViewEdits, ACurveThatIsLeftToTheDatasetIsSaidOnceItIsEdited) {
    const auto view = viewOf(R"("hybrid": {"clipPlanes": [{"normal": [0, 0, 1]}]})");
    ViewModel model;
    load(view, model);
    auto& hybrid = controls<HybridEditor>(model);
    EXPECT_EQ(model.clip().planes_size(), 1);
    EXPECT_GT(hybrid.curve.knots().size(), 1U);
    EXPECT_TRUE(hybrid.curve.colors().empty());  // a server takes those of the view
    EXPECT_EQ(toJson(model.edited()), toJson(view));
    hybrid.curve.move(0, {hybrid.curve.knots()[0].x, 0.01});
    EXPECT_EQ(changedFields(view, model.edited()), Fields{"layers[0].hybrid.curve"});
}

TEST(ViewEdits, ADatasetThatIsMadeAnewTakesNothingOfTheView) {
    const auto view = viewOf(R"("hybrid": {"clipPlanes": [{"normal": [0, 0, 1]}], "colorRange": [1, 2]})");
    ViewModel model;
    load(view, model);
    auto manifest = manifestFor(view.layers(0));
    manifest.mutable_hybrid()->set_value_max(7000.0);
    model.setDataset("a/b", manifest);
    EXPECT_EQ(model.clip().planes_size(), 1);
    EXPECT_TRUE(controls<HybridEditor>(model).ownColorRange);
    EXPECT_EQ(toJson(model.edited()), toJson(view));
}

TEST(ViewEdits, AViewWithoutLayersStaysOneUntilADatasetIsChosen) {
    proto::View view;
    view.set_width(64);
    view.set_height(48);
    ViewModel model;
    ASSERT_TRUE(model.load(view).ok());
    EXPECT_TRUE(model.isLoaded());
    EXPECT_FALSE(model.hasDataset());
    EXPECT_EQ(toJson(model.edited()), toJson(view));
    proto::Layer layer;
    layer.mutable_hybrid();
    model.setDataset("a/volume", manifestFor(layer));
    EXPECT_TRUE(model.edited().layers(0).has_hybrid());
    EXPECT_TRUE(parseView(model.view(64, 48)).ok());
}

TEST(ViewEdits, ACameraIsFittedToAllLayers) {
    auto view = viewOf(R"("particles": {})");
    auto& second = *view.add_layers();
    second.set_dataset("a/far");
    second.mutable_hybrid();
    ViewModel model;
    load(view, model);
    EXPECT_EQ(model.unknownDatasets(), std::vector<std::string>{"a/far"});
    const auto before = model.camera(1.0).target;
    model.know("a/far", manifestFor(second));  // a box from 0 to (40, 20, 20)
    EXPECT_TRUE(model.unknownDatasets().empty());
    EXPECT_NE(model.camera(1.0).target, before);
    EXPECT_NEAR(model.camera(1.0).target.x, 19.5, 1e-9);
    EXPECT_EQ(toJson(model.edited()), toJson(view));
}

// ----------------------------------------------------------------------------- a hand on the whole panel

/// What one control is about: a curve with all that is linked to it, a camera; else its field.
std::string controlOf(const std::string& field) {
    if (field.starts_with("camera")) return "camera";
    for (const char* word : {".curve", ".linked", ".color_map", ".color_range"}) {
        if (field.find(word) != field.npos && field.find("color_by") == field.npos)
            return "transfer function";
    }
    for (const char* word : {"selections", "highlight", "select", "paths"}) {
        if (field.find(word) != field.npos) return "selection";
    }
    if (field.find(".clip") != field.npos) return "cut";  // those of a style become the layer's
    if (field.find("color_by") != field.npos) return "colours by a column";
    if (field.ends_with("step") || field.ends_with("towards")) return "step";
    return field;
}

/// Another kind of layer drawn: nothing of the old style stays.
bool isOtherKind(const proto::View& before, const proto::View& after) {
    return before.layers(0).kind_case() != after.layers(0).kind_case();
}

TEST(ViewEdits, AGestureOnThePanelChangesWhatItIsOnAlone) {
    int changes = 0;
    for (std::uint64_t i = 0; i < 150; ++i) {
        const auto view = generatedView(43, i);
        if (view.layers().empty()) continue;
        Random random(43, i);
        ViewModel model;
        load(view, model);
        PanelHand hand;
        hand.describe(manifestFor(view.layers(0)));
        hand.showNumbers(random.chance(0.3));
        for (int gesture = 0; gesture < 12; ++gesture) {
            const auto before = model.edited();
            hand.drag(model, random);
            const auto after = model.edited();
            if (before.layers_size() != after.layers_size()) break;  // one came or went
            if (isOtherKind(before, after)) break;
            Fields controls;
            for (const auto& field : changedFields(before, after)) controls.insert(controlOf(field));
            // A camera that was of another space is fitted anew.
            if (controls.contains("space")) controls.erase("camera");
            EXPECT_LE(controls.size(), 1U) << "gesture " << gesture << " on view " << i << ": "
                                           << testing::PrintToString(changedFields(before, after));
            changes += controls.empty() ? 0 : 1;
            EXPECT_TRUE(parseView(model.view(64, 48)).ok()) << "gesture " << gesture << " on view " << i;
        }
    }
    EXPECT_GT(changes, 200);
}

}  // namespace
}  // namespace mote::client
