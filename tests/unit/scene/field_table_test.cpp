// SPDX-License-Identifier: GPL-3.0-or-later
//
// The table of fields in docs/SCRIPTS.md is what the schema says. With MOTE_WRITE_DOCS in the environment it
// is written.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "protocol/mote.pb.h"
#include "protocol/scene/fields/facts.h"

namespace mote {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using proto::Facts;

constexpr std::string_view begin = "<!-- made by MOTE_WRITE_DOCS=1 test-scene from protocol/mote.proto -->\n",
                           end = "<!-- end of what is made -->\n";

std::string unitOf(const Facts& facts) {
    if (facts.as() == Facts::LENGTH) return " pixels";
    return facts.unit().empty() ? "" : " " + facts.unit();
}

/// What a field may be, in a cell.
std::string mayBe(const FieldDescriptor& field) {
    const auto& facts = factsOf(field);
    if (facts.as() == Facts::COLOR) return "sRGB, three numbers from 0 to 1";
    if (facts.as() == Facts::DIRECTION) return "three numbers";
    if (facts.as() == Facts::COLOR_MAP) return "a colour map";
    if (field.cpp_type() == FieldDescriptor::CPPTYPE_BOOL) return "`true`";
    if (!facts.one_of().empty()) return fmt::format("`{}`", fmt::join(facts.one_of(), "`, `"));
    if (const auto ends = endsOf(field))
        return fmt::format("{} to {}{}", ends->least, ends->greatest, unitOf(facts));
    return field.message_type() != nullptr ? "`{}`, and what follows" : "text";
}

/// What it is where it is not said.
std::string usual(const FieldDescriptor& field) {
    const auto& facts = factsOf(field);
    if (!facts.default_word().empty()) return fmt::format("`{}`", facts.default_word());
    if (facts.default_().empty()) return "";
    const auto value = fmt::format("{}", fmt::join(facts.default_(), ", "));
    return facts.as() == Facts::LENGTH ? value + " at 720 lines" : value;
}

void addRows(const Descriptor& type, const std::string& path, std::string& rows) {
    for (int i = 0; i < type.field_count(); ++i) {
        const auto& field = *type.field(i);
        const auto name = fmt::format("{}.{}", path, field.json_name());
        const auto* const part = field.message_type();
        if (!factsOf(field).help().empty())
            rows += fmt::format("| `{}` | {} | {} | {} |\n", name, factsOf(field).help(), mayBe(field),
                                usual(field));
        if (part != nullptr && part != proto::Light::descriptor() && !field.is_repeated())
            addRows(*part, name, rows);
    }
}

std::string table() {
    std::string rows = "| field | meaning | may be | without it |\n| --- | --- | --- | --- |\n";
    addRows(*proto::StippleStyle::descriptor(), "stipple", rows);
    addRows(*proto::MeshStyle::descriptor(), "mesh", rows);
    addRows(*proto::InkStyle::descriptor(), "ink", rows);
    addRows(*proto::Light::descriptor(), "light", rows);
    return rows;
}

TEST(FieldTable, OfScriptsIsTheSchemas) {
    const auto file = std::filesystem::path(MOTE_TEST_DATA).parent_path().parent_path() / "docs/SCRIPTS.md";
    std::ifstream in(file);
    std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    const auto from = text.find(begin), to = text.find(end);
    ASSERT_TRUE(from != text.npos && to != text.npos && from < to);
    const auto start = from + begin.size();
    if (std::getenv("MOTE_WRITE_DOCS") != nullptr) {
        text.replace(start, to - start, table());
        std::ofstream(file) << text;
    } else {
        EXPECT_EQ(text.substr(start, to - start), table());
    }
}

}  // namespace
}  // namespace mote
