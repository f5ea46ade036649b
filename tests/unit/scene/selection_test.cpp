// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/selection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <string>

#include "protocol/base/json.h"
#include "tests/support/any_selection.h"

namespace mote::test {
namespace {

const SelectionShape everything{.columns = {{"x", -1e-3, 1e-3}, {"px", -2e5, 3e5}, {"delta", -0.1, 0.1}},
                                .ids = 1000,
                                .steps = 60,
                                .nothing = true};

proto::Selection messageOf(std::string json) {
    std::replace(json.begin(), json.end(), '\'', '"');
    proto::Selection message;
    const auto parsed = parseJson(json, message, "selection");
    EXPECT_TRUE(parsed.ok()) << parsed.error().toString();
    return message;
}

Selection selectionOf(const std::string& json) {
    const auto parsed = parseSelection(messageOf(json));
    EXPECT_TRUE(parsed.ok()) << parsed.error().toString();
    return parsed.ok() ? *parsed : Selection();
}

/// Where and why it is refused.
std::string refusalOf(const proto::Selection& message) {
    const auto parsed = parseSelection(message);
    EXPECT_FALSE(parsed.ok()) << toJson(message);
    if (parsed.ok()) return "";
    EXPECT_EQ(parsed.error().code, ErrorCode::invalidArgument);
    return parsed.error().toString();
}

/// A lasso that says its plot.
std::string lassoIn(const std::string& axes, const std::string& bounds) {
    return "{'lasso': {'camera': {'eye': [0, 0, 1], 'target': [0, 0, 0]}, 'aspect': 1, 'points': [[0, 0], "
           "[1, 0], [0, 1]], 'axes': " +
           axes + ", 'bounds': " + bounds + "}}";
}

TEST(Selection, ComesBackFromItsMessageAndFromAFile) {
    Random random(1);
    int lively = 0;
    for (int i = 0; i < 3000; ++i) {
        const auto selection = anySelection(random, everything);
        const auto message = toProto(selection);
        const auto parsed = parseSelection(message);
        ASSERT_TRUE(parsed.ok()) << parsed.error().toString() << toJson(message);
        ASSERT_TRUE(*parsed == selection) << toJson(message);
        proto::Selection again;
        ASSERT_TRUE(parseJson(toJson(message), again, "file").ok());
        ASSERT_EQ(again.SerializeAsString(), message.SerializeAsString());
        lively += !selection.everything();
    }
    EXPECT_GT(lively, 2000);
}

TEST(Selection, IsWrittenAsTheInterfaceSays) {
    const auto selection = selectionOf(
        "{'ranges': [{'column': 'x', 'min': 1e-3}], 'density': {'max': 0.4},"
        "'polygon': {'columns': ['x', 'px'], 'points': [[0, 0], [1e-3, 0], [0, 2000.5]]},"
        "'ids': [7, 3, '18446744073709551615', 3], 'step': 12, 'all': [{'ids': [1]}],"
        "'any': [{'density': {}}, {}], 'not': {'outermost': {'plane': 'y', 'share': 0.01}}}");
    ASSERT_EQ(selection.ranges.size(), 1U);
    EXPECT_EQ(selection.ranges[0], (Selection::Range{"x", 1e-3, std::numeric_limits<double>::infinity()}));
    EXPECT_EQ(selection.density->max, 0.4);
    EXPECT_EQ(selection.polygon->first, "x");
    EXPECT_EQ(selection.polygon->second, "px");
    EXPECT_EQ(selection.polygon->points[2], glm::dvec2(0.0, 2000.5));
    EXPECT_EQ(selection.ids, (std::vector<std::uint64_t>{3, 7, ~std::uint64_t{0}}));
    EXPECT_EQ(selection.step, 12U);
    EXPECT_EQ(selection.all.size(), 1U);
    EXPECT_EQ(selection.any.size(), 2U);
    EXPECT_TRUE(selection.any[1].everything());
    EXPECT_EQ(selection.negated.at(0).outermost->share, 0.01);
    EXPECT_NE(toJsonLine(toProto(selection)).find("\"not\":{\"outermost\""), std::string::npos);
    EXPECT_TRUE(selectionOf("{}").everything());
    EXPECT_FALSE(selectionOf("{'step': 0}").everything());
}

TEST(Selection, SaysWhichFieldIsWrong) {
    const std::vector<std::pair<std::string, std::string>> wrong{
        {"{'ranges': [{}]}", "ranges[0].column: the name of a column is missing"},
        {"{'ranges': [{'column': 'x'}, {'column': 'x', 'min': 2, 'max': 1}]}",
         "ranges[1].max: lies below the min: 1 < 2"},
        {"{'ranges': [{'column': 'x', 'min': 'NaN'}]}",
         "ranges[0].min: a bound is a finite number; where there is none it is left out"},
        {"{'ranges': [{'column': 'x', 'max': 'Infinity'}]}",
         "ranges[0].max: a bound is a finite number; where there is none it is left out"},
        {"{'ranges': [{'column': 'x\\n'}]}", "ranges[0].column: holds a control character"},
        {"{'density': {'min': 40}}", "density.min: 40 is not a number from 0 to 1"},
        {"{'density': {'min': 0.5, 'max': 0.25}}", "density.max: lies below the min: 0.25 < 0.5"},
        {"{'polygon': {'points': [[0, 0], [1, 0], [1, 1]]}}", "polygon.columns: two names are needed, not 0"},
        {"{'polygon': {'columns': ['x', 'x'], 'points': [[0, 0], [1, 0], [1, 1]]}}",
         "polygon.columns[1]: \"x\" is given twice"},
        {"{'polygon': {'columns': ['x', ''], 'points': [[0, 0], [1, 0], [1, 1]]}}",
         "polygon.columns[1]: the name of a column is missing"},
        {"{'polygon': {'columns': ['x', 'y'], 'points': [[0, 0], [1, 0]]}}",
         "polygon.points: at least 3 are needed, not 2"},
        {"{'polygon': {'columns': ['x', 'y'], 'points': [[0, 0], [1, 0], [1, 1], [1]]}}",
         "polygon.points[3]: two numbers are needed"},
        {"{'polygon': {'columns': ['x', 'y'], 'points': [[0, 0], ['NaN', 0], [1, 1]]}}",
         "polygon.points[1]: two numbers are needed"},
        {"{'polygon': {'columns': ['x', 'y'], 'points': [[0, 0], [1, 1e31], [1, 1]]}}",
         "polygon.points[1][1]: 1e+31 is not a number from -1e+30 to 1e+30"},
        {"{'lasso': {'points': [[0, 0], [1, 0], [1, 1]]}}",
         "lasso.camera: a lasso needs the camera of its picture"},
        {"{'lasso': {'camera': {'eye': [0, 0, 1], 'target': [0, 0, 1]}}}",
         "lasso.camera.target: the target must differ from the eye"},
        {"{'lasso': {'camera': {'eye': [0, 0, 1], 'target': [0, 0, 0]}}}",
         "lasso.aspect: 0 is not a number from 6.103515625e-05 to 16384"},
        {"{'lasso': {'camera': {'eye': [0, 0, 1], 'target': [0, 0, 0]}, 'aspect': 1.5, 'transform': [1]}}",
         "lasso.transform: 16 numbers are needed, not 1"},
        {lassoIn("['x', 'px']", "[[0, 1], [0, 1], [0, 1]]"), "lasso.axes: a plot has 3, not 2"},
        {lassoIn("['x', 'px', 'y']", "[[0, 1]]"), "lasso.bounds: a plot has 3, not 1"},
        {lassoIn("[]", "[[0, 1], [0, 1], [0, 1]]"), "lasso.axes: a plot has 3, not 0"},
        {lassoIn("['x', '', 'y']", "[[0, 1], [0, 1], [0, 1]]"),
         "lasso.axes[1]: the name of a column is missing"},
        {lassoIn("['x', 'px', 'y']", "[[0, 1], [0, 1], [1, 1]]"),
         "lasso.bounds[2]: the second value must be the greater one"},
        {lassoIn("['x', 'px', 'y']", "[[0, 1], [0], [0, 1]]"), "lasso.bounds[1]: two numbers are needed"},
        {lassoIn("['x', 'px', 'y']", "[[0, 1], [0, 'a'], [0, 1]]"),
         "lasso.bounds[1]: two numbers are needed"},
        {lassoIn("['x', 'px', 'y']", "[[0, 1], [0, 1], [-1e301, 1]]"),
         "lasso.bounds[2][0]: -1e+301 is not a number from -1e+300 to 1e+300"},
        {"{'outermost': {'plane': 'r', 'share': 0.5}}", "outermost.plane: there are \"x\", \"y\" and \"z\""},
        {"{'outermost': {'plane': 'z', 'share': 1.5}}", "outermost.share: 1.5 is not a number from 0 to 1"},
        {"{'all': [{}, {'any': [{'not': {'density': {'max': -1}}}]}]}",
         "all[1].any[0].not.density.max: -1 is not a number from 0 to 1"},
        {"{'named': 'halo'}", "named: there is no selection \"halo\"; none has a name here"},
    };
    for (const auto& [json, sentence] : wrong) EXPECT_EQ(refusalOf(messageOf(json)), sentence) << json;
}

TEST(Selection, NumbersThatAreNoneAreRefused) {
    auto message =
        toProto(selectionOf("{'polygon': {'columns': ['x', 'y'], 'points': [[0, 0], [1, 0], [1, 1]]}}"));
    message.mutable_polygon()->mutable_points(2)->mutable_values(0)->set_number_value(
        std::numeric_limits<double>::quiet_NaN());
    EXPECT_EQ(refusalOf(message), "polygon.points[2][0]: nan is not a number from -1e+30 to 1e+30");
}

proto::Selection polygonOf(int points) {
    proto::Selection message;
    message.mutable_polygon()->add_columns("x");
    message.mutable_polygon()->add_columns("y");
    for (int i = 0; i < points; ++i) {
        auto& point = *message.mutable_polygon()->add_points();
        point.add_values()->set_number_value(i);
        point.add_values()->set_number_value(i % 7);
    }
    return message;
}

TEST(Selection, HoldsNoMoreThanItMay) {
    EXPECT_TRUE(parseSelection(polygonOf(100000)).ok());
    EXPECT_EQ(refusalOf(polygonOf(100001)), "polygon.points: there may be at most 100000, not 100001");
    EXPECT_EQ(refusalOf(polygonOf(1000000)), "polygon.points: there may be at most 100000, not 1000000");
    proto::Selection many;
    for (int i = 0; i < 11; ++i) *many.add_any() = polygonOf(100000);
    EXPECT_EQ(refusalOf(many),
              "any[10].polygon.points: a selection has at most 1048576 ids and points in all");
    proto::Selection ids;
    for (int i = 0; i <= 1 << 20; ++i) ids.add_ids(5);
    EXPECT_EQ(refusalOf(ids), "ids: a selection has at most 1048576 ids and points in all");
    ids.mutable_ids()->RemoveLast();
    EXPECT_EQ(parseSelection(ids)->ids, std::vector<std::uint64_t>{5});
}

TEST(Selection, HasNoMoreConditionsThanItMay) {
    proto::Selection deep;
    for (int i = 1; i < Selection::maxDepth; ++i) {
        proto::Selection outer;
        *outer.mutable_negated() = deep;
        deep = outer;
    }
    EXPECT_TRUE(parseSelection(deep).ok());
    proto::Selection deeper;
    *deeper.add_all() = deep;
    std::string path = "all[0]";
    for (int i = 1; i < Selection::maxDepth; ++i) path += ".not";
    EXPECT_EQ(refusalOf(deeper), path + ": there are more than 16 selections in each other");
    proto::Selection wide;
    for (int i = 0; i < Selection::maxConditions; ++i) wide.add_ranges()->set_column("x");
    EXPECT_TRUE(parseSelection(wide).ok());
    wide.add_any();
    EXPECT_EQ(refusalOf(wide), "any[0]: a selection has at most 256 conditions in all");
    wide.add_ranges()->set_column("x");
    EXPECT_EQ(refusalOf(wide), "ranges: a selection has at most 256 conditions in all");
}

TEST(Selection, AListThatIsThereAndEmptySelectsNothing) {
    for (const char* list : {"ids", "ranges", "any", "all"}) {
        for (const char* empty : {"[]", " [ ] ", "[\n]", "[null]", "[[]]"}) {
            const auto json = std::string("{'") + list + "': " + empty + "}";
            const auto selection = selectionOf(json);
            EXPECT_TRUE(selection.nothing) << json;
            EXPECT_FALSE(selection.everything()) << json;
        }
        EXPECT_TRUE(selectionOf(std::string("{'") + list + "': null}").everything()) << list;
    }
    // However it is written; a word of its own does not take it back.
    for (const char* json :
         {"{ids: []}", "{'i\\u0064s': []}", "{'density': {'max': 0.5}, 'ids': [],}",
          "{'nothing': false, 'any': []}", "{'any': [], 'nothing': false}", "{'nothing': true}"})
        EXPECT_TRUE(selectionOf(json).nothing) << json;
    for (const char* json : {"{'ids': [], 'ids': [3]}", "{'ids': [7]}", "{'ids': 7}", "{'any': [{}]}",
                             "{'all': {}}", "{'step': 2}", "{'nothing': false}"})
        EXPECT_FALSE(selectionOf(json).nothing) << json;
    // What is empty in a text is no list.
    EXPECT_FALSE(selectionOf("{'ranges': [{'column': '\\\"ids\\\": [], {'}]}").nothing);
}

TEST(Selection, EachPartKnowsItsOwnEmptyLists) {
    const auto selection = selectionOf(
        "{'all': [{'ids': [1]}, null, {'any': []}, {}], 'all': [{'not': {'ids': []}}],"
        "'not': {'any': [{'ranges': []}, {'ids': [2]}]}, 'polygon': {'columns': ['x', 'y'],"
        "'points': [[0, 0], [1, 0], [0, 1]]}}");
    ASSERT_EQ(selection.all.size(), 4U);
    EXPECT_FALSE(selection.nothing);
    EXPECT_FALSE(selection.all[0].nothing);
    EXPECT_TRUE(selection.all[1].nothing);
    EXPECT_TRUE(selection.all[2].everything());
    EXPECT_FALSE(selection.all[3].nothing);
    EXPECT_TRUE(selection.all[3].negated.at(0).nothing);
    EXPECT_TRUE(selection.negated.at(0).any.at(0).nothing);
    EXPECT_FALSE(selection.negated.at(0).any.at(1).nothing);
}

TEST(Selection, EmptyListsAreToldWhereverASelectionIs) {
    proto::Script script;
    ASSERT_TRUE(parseJson(R"({"views": [{}, {"layers": [{"select": {"ids": []}, "paths": {"ids": []}},
        {"highlight": {"selection": {"any": []}, "color": []}}],
        "selections": [{"name": "a", "selection": {}}, {"name": "b", "selection": {"ranges": []}}]}]})",
                          script, "script")
                    .ok());
    const auto& view = script.views(1);
    EXPECT_TRUE(view.layers(0).select().nothing());
    EXPECT_TRUE(view.layers(1).highlight().selection().nothing());
    EXPECT_FALSE(view.selections(0).selection().nothing());
    EXPECT_TRUE(view.selections(1).selection().nothing());
    proto::JobRequest job;
    ASSERT_TRUE(parseJson(R"({"export": {"columns": [], "select": {"not": {"ids": []}}}})", job, "job").ok());
    EXPECT_TRUE(job.export_().select().negated().nothing());
    EXPECT_FALSE(job.export_().select().nothing());
}

TEST(Selection, TheDeepestAndTheWidestTextIsFollowed) {
    std::string deep = "{'ids': []}";
    for (int i = 1; i < Selection::maxDepth; ++i) deep = "{'any': [" + deep + "]}";
    const auto* selection = new proto::Selection(messageOf(deep));
    const std::unique_ptr<const proto::Selection> outermost(selection);
    for (int i = 1; i < Selection::maxDepth; ++i) selection = &selection->any(0);
    EXPECT_TRUE(selection->nothing());
    std::string wide = "{'any': [";
    for (int i = 0; i < 120; ++i) wide += i % 3 == 0 ? "{'ids': []}," : "{'ids': [5]},";
    const auto parts = selectionOf(wide + "]}").any;
    ASSERT_EQ(parts.size(), 120U);
    for (std::size_t i = 0; i < parts.size(); ++i) EXPECT_EQ(parts[i].nothing, i % 3 == 0) << i;
}

TEST(Selection, AllFieldsWrittenDownMeanTheSame) {
    Random random(4);
    for (int i = 0; i < 300; ++i) {
        proto::JobRequest job, again;
        *job.mutable_export_()->mutable_select() = toProto(anySelection(random, everything));
        job.set_title("\"ids\":[],");
        ASSERT_TRUE(parseJson(toJsonLine(job, true), again, "job").ok());
        ASSERT_EQ(again.SerializeAsString(), job.SerializeAsString()) << toJsonLine(job, true);
    }
}

TEST(Selection, NamesKeepWhatHoldsNothing) {
    NamedSelectionMessages names;
    names.Add()->set_name("none");
    *names[0].mutable_selection() = messageOf("{'ids': []}");
    EXPECT_TRUE(parseSelection(messageOf("{'named': 'none'}"), names)->nothing);
    EXPECT_TRUE(parseSelection(messageOf("{'not': {'named': 'none'}}"), names)->negated.at(0).nothing);
    // Conditions of a selection of nothing do not make it all.
    const auto both = parseSelection(messageOf("{'named': 'none', 'ids': [1]}"), names).value();
    EXPECT_TRUE(both.all.at(0).nothing);
}

/// "name=json" each.
NamedSelectionMessages namesOf(const std::vector<std::pair<std::string, std::string>>& list) {
    NamedSelectionMessages names;
    for (const auto& [name, json] : list) {
        auto& added = *names.Add();
        added.set_name(name);
        *added.mutable_selection() = messageOf(json);
    }
    return names;
}

TEST(Selection, NamesStandForWhatTheyName) {
    const auto names = namesOf(
        {{"halo", "{'density': {'max': 0.3}}"}, {"far", "{'named': 'halo', 'step': 3, 'ids': [1, 2]}"}});
    EXPECT_TRUE(parseSelection(messageOf("{'named': 'halo'}"), names).value() ==
                selectionOf("{'density': {'max': 0.3}}"));
    EXPECT_TRUE(parseSelection(messageOf("{'not': {'named': 'far'}}"), names).value() ==
                selectionOf("{'not': {'step': 3, 'ids': [1, 2], 'all': [{'density': {'max': 0.3}}]}}"));
    const auto parsed = parseNamedSelections(names).value();
    ASSERT_EQ(parsed.size(), 2U);
    EXPECT_EQ(parsed[1].name, "far");
    EXPECT_EQ(parsed[1].selection.all.size(), 1U);
}

std::string refusalOf(const std::string& json, const NamedSelectionMessages& names) {
    const auto parsed = parseSelection(messageOf(json), names);
    EXPECT_FALSE(parsed.ok());
    return parsed.ok() ? "" : parsed.error().toString();
}

TEST(Selection, NamesThatAreWrong) {
    const auto names = namesOf({{"self", "{'all': [{'named': 'self'}]}"},
                                {"a", "{'named': 'b'}"},
                                {"b", "{'named': 'a'}"},
                                {"bad", "{'ids': [1], 'ranges': [{'column': ''}]}"}});
    EXPECT_EQ(refusalOf("{'all': [{'named': 'nobody'}]}", names),
              "all[0].named: there is no selection \"nobody\"; there are \"self\", \"a\", \"b\", \"bad\"");
    EXPECT_EQ(refusalOf("{'named': 'self'}", names),
              "named: in \"self\": all[0].named: the selection \"self\" holds itself");
    EXPECT_EQ(refusalOf("{'named': 'a'}", names), "named: the selection \"a\" holds itself");
    EXPECT_EQ(refusalOf("{'named': 'bad'}", names),
              "named: in \"bad\": ranges[0].column: the name of a column is missing");
    const auto error = parseNamedSelections(namesOf({{"a", "{}"}, {"b", "{}"}, {"a", "{}"}})).error();
    EXPECT_EQ(error.within("selections").toString(), "selections[2].name: \"a\" is given twice");
    EXPECT_EQ(parseNamedSelections(namesOf({{"", "{}"}})).error().where, "[0].name");
    EXPECT_EQ(parseNamedSelections(namesOf({{"a", "{'density': {'min': 2}}"}})).error().where,
              "[0].selection.density.min");
}

TEST(Selection, NamesDoNotGrowWithoutBound) {
    // Each name doubles the one before: 2^15 conditions of a message of a hundred bytes.
    std::vector<std::pair<std::string, std::string>> list{{"n0", "{'density': {'max': 0.5}}"}};
    for (int i = 1; i < 16; ++i) {
        const auto before = "{'named': 'n" + std::to_string(i - 1) + "'}";
        list.emplace_back("n" + std::to_string(i), "{'any': [" + before + ", " + before + "]}");
    }
    const auto refusal = refusalOf("{'named': 'n15'}", namesOf(list));
    EXPECT_NE(refusal.find("at most 256 conditions"), std::string::npos) << refusal;
    EXPECT_LT(refusal.size(), 2000U);
    auto names = namesOf({{"ids", "{}"}});
    for (std::uint64_t i = 0; i < 300000; ++i) names[0].mutable_selection()->add_ids(i);
    const auto again = refusalOf(
        "{'any': [{'named': 'ids'}, {'named': 'ids'}, {'named': 'ids'}, {'named': "
        "'ids'}]}",
        names);
    EXPECT_NE(again.find("at most 1048576 ids"), std::string::npos) << again;
}

TEST(Selection, AnyBytesAreRefusedOrComeBack) {
    Random random(2);
    int kept = 0;
    for (int i = 0; i < 20000; ++i) {
        auto bytes = toProto(anySelection(random, everything)).SerializeAsString();
        for (auto changes = random.below(4); changes > 0 && !bytes.empty(); --changes)
            bytes[random.below(bytes.size())] = static_cast<char>(random.below(256));
        proto::Selection message;
        if (!message.ParseFromString(bytes)) continue;
        const auto parsed = parseSelection(message);
        if (!parsed.ok()) {
            EXPECT_FALSE(parsed.error().message.empty());
            continue;
        }
        ++kept;
        const auto again = parseSelection(toProto(*parsed));
        ASSERT_TRUE(again.ok()) << again.error().toString();
        ASSERT_TRUE(*again == *parsed);
    }
    EXPECT_GT(kept, 1000);
}

}  // namespace
}  // namespace mote::test
