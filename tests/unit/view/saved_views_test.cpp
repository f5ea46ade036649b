// SPDX-License-Identifier: GPL-3.0-or-later
//
// Views that are loaded and saved without a touch are the same to the byte: generated ones, those of the
// corpus, of the fuzzers, of the manual and of what is installed. What is drawn in between is the whole
// panel.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "client/view/view_model.h"
#include "protocol/base/json.h"
#include "protocol/scene/view.h"
#include "tests/unit/view/panel_hand.h"
#include "tests/views/out_of_range.h"
#include "tests/views/view_generator.h"

namespace mote::client {
namespace {

using test::generatedView;
using test::Random;

constexpr std::uint64_t viewCount = 10'000;

class SavedViews : public testing::Test {
  protected:
    /// As a file would hold it; the panel is drawn before the server has described the dataset, and after,
    /// and its other side.
    std::string through(const std::string& text) {
        proto::View view;
        EXPECT_TRUE(parseJson(text, view, "view").ok());
        ViewModel model;
        const auto loaded = model.load(view);
        if (!loaded.ok()) return loaded.error().toString();
        if (!view.layers().empty()) {
            const auto manifest = manifestFor(view.layers(0));
            hand_.describe(manifest);
            hand_.showNumbers(false);
            hand_.draw(model);
            model.setDataset(view.layers(0).dataset(), manifest);  // as when a server answers
            hand_.draw(model);
            hand_.showNumbers(true);
        }
        hand_.draw(model);
        return toJson(model.saved(1260, 900));
    }

    void expectKept(const proto::View& view, const std::string& name) {
        const auto text = toJson(view);
        ASSERT_EQ(through(text), text) << name;
    }

    PanelHand hand_;
};

TEST_F(SavedViews, OfTheGeneratorAreKept) {
    for (std::uint64_t i = 0; i < viewCount && !HasFailure(); ++i)
        expectKept(generatedView(31, i), fmt::format("view {} of seed 31", i));
}

/// Each number that a view says, another one a hair beside it: no float tells them apart.
void shake(google::protobuf::Message& message, Random& random) {
    using google::protobuf::FieldDescriptor;
    const auto& reflection = *message.GetReflection();
    std::vector<const FieldDescriptor*> fields;
    reflection.ListFields(message, &fields);
    const auto shaken = [&](double value) {
        return value * (1.0 - 1e-12 * static_cast<double>(random.below(9)));
    };
    for (const auto* field : fields) {
        if (field->name() == "transform") continue;  // its last row has nothing beside it
        const int count = field->is_repeated() ? reflection.FieldSize(message, field) : 0;
        if (field->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE && !field->is_repeated())
            reflection.SetDouble(&message, field, shaken(reflection.GetDouble(message, field)));
        if (field->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) {
            for (int i = 0; i < count; ++i) {
                reflection.SetRepeatedDouble(&message, field, i,
                                             shaken(reflection.GetRepeatedDouble(message, field, i)));
            }
        }
        if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) continue;
        for (int i = 0; i < count; ++i) shake(*reflection.MutableRepeatedMessage(&message, field, i), random);
        if (!field->is_repeated()) shake(*reflection.MutableMessage(&message, field), random);
    }
}

TEST_F(SavedViews, KeepNumbersToTheLastDigit) {
    std::uint64_t kept = 0;
    for (std::uint64_t i = 0; i < viewCount / 4 && !HasFailure(); ++i) {
        auto view = generatedView(32, i);
        Random random(32, i);
        shake(view, random);
        if (!parseView(view).ok()) continue;  // beyond an end now
        expectKept(view, fmt::format("view {} of seed 32", i));
        ++kept;
    }
    EXPECT_GT(kept, viewCount / 16);
}

TEST_F(SavedViews, KeepWhatNoFloatHolds) {
    const std::string head =
        R"({"width": 640, "height": 480, "layers": [{"dataset": "a/b", "step": 4000000000, )";
    for (
        const char* layer :
        {R"("hybrid": {"colorRange": [101325.001, 101325.002], "curve": [{"value": 101325.0011}]})",
         R"("hybrid": {"clipBox": {"min": [500000.001, 0, -1e-12], "max": [500000.002, 0.001, 1e-12]}})",
         R"("hybrid": {"clipPlanes": [{"normal": [0, 3, 4], "distance": 101325.001}, {"normal": [1, 0, 0]}]})",
         R"("mesh": {"light": {"ambient": 0.25, "diffuse": 0.25}})",
         R"("mesh": {"light": {"direction": [4, 6, 7]}})", R"("ink": {"light": {"diffuse": 0}})",
         R"("ink": {"ink": {}})", R"("stipple": {"light": {"ambient": 1}})",
         R"("particles": {}, "towards": {"step": 3, "share": 0.123456789012345})",
         R"("particles": {"points": {"opacity": 0.1, "color": [0.1, 0.2, 0.3]}}, "select": {"ranges": [{"column": "x"}]})",
         R"("particles": {}, "highlight": {"selection": {"density": {"max": 0.1}}}, "paths": {})"}) {
        proto::View view;
        const auto status = parseJson(head + layer + "}]}", view, "view");
        ASSERT_TRUE(status.ok()) << status.error().toString();
        expectKept(view, layer);
    }
}

// ------------------------------------------------------------------------------------- views of files

std::string textOf(const std::filesystem::path& path) {
    std::ostringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    return text.str();
}

/// All that a text holds, be it a view or a script; none if it is neither.
std::vector<proto::View> viewsIn(const std::string& text) {
    proto::View view;
    if (parseJson(text, view, "text").ok()) return {view};
    proto::Script script;
    if (!parseJson(text, script, "text").ok()) return {};
    std::vector<proto::View> all(script.views().begin(), script.views().end());
    for (const auto& keyframe : script.keyframes()) all.push_back(keyframe.view());
    if (script.has_view()) all.push_back(script.view());
    return all;
}

/// What stands between marks that begin and end an example.
std::vector<std::string> examplesIn(const std::string& page) {
    const std::string begin = "```json\n", end = "```";
    std::vector<std::string> examples;
    for (auto at = page.find(begin); at != page.npos; at = page.find(begin, at)) {
        at += begin.size();
        examples.push_back(page.substr(at, page.find(end, at) - at));
    }
    return examples;
}

class SavedFiles : public SavedViews {
  protected:
    /// Valid ones are kept, others refused with a sentence; how many were kept.
    int keep(const std::string& text, const std::string& name) {
        int kept = 0;
        for (const auto& view : viewsIn(text)) {
            auto sized = view;
            if (sized.width() == 0) sized.set_width(1280);
            if (sized.height() == 0) sized.set_height(720);
            if (parseView(sized).ok()) {
                expectKept(view, name);
                ++kept;
            } else {
                EXPECT_FALSE(ViewModel().load(view).ok()) << name;
            }
        }
        return kept;
    }
    int keepFolder(const std::filesystem::path& folder) {
        int kept = 0;
        for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
            if (entry.path().extension() == ".json")
                kept += keep(textOf(entry.path()), entry.path().string());
        return kept;
    }

    const std::filesystem::path source_{MOTE_SOURCE};
};

TEST_F(SavedFiles, OfTheCorpusAreKept) {
    EXPECT_GE(keepFolder(source_ / "tests/views/corpus"), 22);
}

TEST_F(SavedFiles, OfTheFuzzersAreKeptOrRefused) {
    int kept = 0;
    for (const auto& entry : std::filesystem::directory_iterator(source_ / "tests/fuzz/corpus/scene")) {
        const auto text = textOf(entry.path());
        kept += keep(text.substr(std::min(text.find('\n'), text.size())), entry.path().string());
    }
    EXPECT_GE(kept, 3);
}

TEST_F(SavedFiles, OfWhatIsInstalledAreKept) {
    EXPECT_GE(keepFolder(source_ / "deploy"), 6);
}

TEST_F(SavedFiles, OfTheManualAreKept) {
    int kept = 0;
    for (const auto& entry : std::filesystem::directory_iterator(source_ / "docs")) {
        if (entry.path().extension() != ".md") continue;
        for (const auto& example : examplesIn(textOf(entry.path())))
            kept += keep(example, entry.path().string());
    }
    EXPECT_GE(kept, 4);
}

// ------------------------------------------------------------------------------------------ spoiled ones

TEST_F(SavedViews, SpoiledOnesAreRefusedWithASentence) {
    ViewModel model;
    const auto before = toJson(model.saved(64, 48));
    for (std::uint64_t i = 0; i < 2000; ++i) {
        Random random(33, i);
        const auto view = generatedView(33, i);
        const auto fault =
            i % 2 == 0 ? test::beyondItsEnds(random, view) : test::withoutANumber(random, view);
        if (fault.view.width() == 0 || fault.view.height() == 0) continue;  // left to the window
        const auto loaded = model.load(fault.view);
        ASSERT_FALSE(loaded.ok()) << fault.what;
        EXPECT_FALSE(loaded.error().message.empty()) << fault.what;
        EXPECT_FALSE(loaded.error().where.empty()) << fault.what;
    }
    EXPECT_EQ(toJson(model.saved(64, 48)), before);
}

}  // namespace
}  // namespace mote::client
