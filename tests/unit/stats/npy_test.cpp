// SPDX-License-Identifier: GPL-3.0-or-later
//
// The form of NumPy files, by NEP 1; numpy itself reads them in tests/python/stats_test.py.
#include "client/stats/npy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temp_dir.h"

namespace mote::client {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

std::string contentOf(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// The head's text, after its form was checked.
std::string textOf(const std::string& head) {
    EXPECT_THAT(head, StartsWith(std::string("\x93NUMPY\x01\x00", 8)));
    EXPECT_EQ(head.size() % 64, 0U);
    EXPECT_EQ(static_cast<unsigned char>(head[8]) + 256U * static_cast<unsigned char>(head[9]),
              head.size() - 10);
    EXPECT_THAT(head, EndsWith("\n"));
    return head.substr(10);
}

TEST(Npy, HeadsSayShapeAndType) {
    EXPECT_THAT(textOf(npyHead({7})),
                StartsWith("{'descr': '<f8', 'fortran_order': False, 'shape': (7,), }"));
    EXPECT_THAT(textOf(npyHead({2, 512, 4096})), HasSubstr("'shape': (2, 512, 4096,)"));
}

TEST(Npy, RowsAreCountedWhenTheyAreAllThere) {
    const test::TempDir folder;
    const auto path = folder / "rows.npy";
    auto rows = NpyRows::create(path, {{"id", "<u8"}, {"it's \\ \u00b5", "<f8"}});
    ASSERT_TRUE(rows.ok());
    const std::vector<std::uint64_t> words{1, 2, 3, 4, 5, 6};
    ASSERT_TRUE(rows->append(words).ok());
    ASSERT_TRUE(rows->append({}).ok());
    EXPECT_FALSE(std::filesystem::exists(path));
    ASSERT_TRUE(rows->publish().ok());
    const auto content = contentOf(path);
    const auto text = textOf(content.substr(0, content.size() - 48));
    EXPECT_THAT(text, HasSubstr(R"([('id', '<u8'), ('it\x27s \x5c \U000000b5', '<f8')])"));
    EXPECT_THAT(text, HasSubstr("'shape': (3,)"));
    EXPECT_EQ(content.substr(content.size() - 48),
              std::string(reinterpret_cast<const char*>(words.data()), 48));
}

TEST(Npy, WhatIsNotPublishedLeavesNothing) {
    const test::TempDir folder;
    {
        auto rows = NpyRows::create(folder / "rows.npy", {{"x", "<f8"}});
        ASSERT_TRUE(rows.ok());
        ASSERT_TRUE(rows->append(std::vector<std::uint64_t>{1}).ok());
    }
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Npy, TooManyFieldsAreRefused) {
    const test::TempDir folder;
    const std::vector<NpyField> fields(4000, {"a_name_of_twenty_byt", "<f8"});
    const auto rows = NpyRows::create(folder / "rows.npy", fields);
    ASSERT_FALSE(rows.ok());
    EXPECT_EQ(rows.error().code, ErrorCode::resourceExhausted);
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace mote::client
