// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is found, told to people and to scripts.
#include <gmock/gmock.h>
#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>

#include <cmath>
#include <limits>

#include "preprocess/look/found.h"

namespace mote::test {
namespace {

using prep::Found;
using prep::FoundColumn;
using testing::HasSubstr;
using testing::Not;

prep::Look anyLook() {
    prep::Look look;
    look.input = "a \"run\"\x1b\n.h5";
    Found found;
    found.kind = "particles";
    found.format = "csv";
    found.facts.push_back({"steps", std::uint64_t{2}, "steps", "2"});
    found.facts.push_back({"times", std::vector<double>{0.0, std::numeric_limits<double>::infinity()}});
    FoundColumn x{"x", "m"}, none{"y", "m"};
    for (const double value : {1.5, std::nan(""), -2.0}) x.take(value);
    none.take(std::numeric_limits<double>::infinity());
    found.columns.push_back(x);
    found.columns.push_back(none);
    found.notes.emplace_back("taken as m");
    look.found.push_back(found);
    return look;
}

TEST(FoundText, IsJson) {
    const std::string line = jsonLine(anyLook());
    google::protobuf::Struct read;
    ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(line, &read).ok()) << line;
    EXPECT_EQ(read.fields().at("input").string_value(), anyLook().input);
    const auto& found = read.fields().at("found").list_value().values(0).struct_value().fields();
    EXPECT_EQ(found.at("steps").number_value(), 2.0);
    EXPECT_TRUE(found.at("times").list_value().values(1).has_null_value());
    const auto& columns = found.at("columns").list_value();
    const auto& x = columns.values(0).struct_value().fields();
    EXPECT_EQ(x.at("min").number_value(), -2.0);
    EXPECT_EQ(x.at("max").number_value(), 1.5);
    EXPECT_EQ(x.at("invalid").number_value(), 1.0);
    EXPECT_TRUE(columns.values(1).struct_value().fields().at("min").has_null_value());
}

TEST(FoundText, HasALineForEachThing) {
    const std::string text = lookText(anyLook());
    EXPECT_THAT(text, HasSubstr("steps    2\n"));
    EXPECT_THAT(text, HasSubstr("column   x from -2 to 1.5 m, 1 not finite\n"));
    EXPECT_THAT(text, HasSubstr("column   y has no finite value, 1 not finite\n"));
    EXPECT_THAT(text, HasSubstr("note     taken as m\n"));
    EXPECT_THAT(text, Not(HasSubstr("times")));
}

TEST(Look, IsWholeWhereNothingIsRefused) {
    auto look = anyLook();
    EXPECT_TRUE(look.whole());
    look.found.front().refused.emplace_back("is cut short");
    EXPECT_FALSE(look.whole());
    EXPECT_FALSE(prep::Look().whole());
}

}  // namespace
}  // namespace mote::test
