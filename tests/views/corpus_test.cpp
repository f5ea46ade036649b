// SPDX-License-Identifier: GPL-3.0-or-later
//
// Views that once failed, shrunk: each is drawn by each device, like the reference and at all qualities.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "protocol/base/json.h"
#include "tests/views/view_check.h"
#include "tests/views/view_drawer.h"

namespace mote::test {
namespace {

using Kind = Verdict::Kind;
using Files = std::vector<std::filesystem::path>;

Files filesIn(const std::filesystem::path& folder) {
    Files files;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.path().extension() == ".json") files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

/// Views that turn on the order of points within a slab, which only cpu and its ranks tell, are in a folder
/// of their own.
Files corpus(bool withinSlabs = true) {
    const std::filesystem::path folder(MOTE_VIEW_CORPUS);
    Files files = filesIn(folder);
    if (!withinSlabs) return files;
    for (auto& file : filesIn(folder / "cpu")) files.push_back(std::move(file));
    return files;
}

proto::View viewIn(const std::filesystem::path& file) {
    proto::View view;
    const auto read = readJsonFile(file, view);
    if (!read.ok()) throw std::runtime_error(read.error().toString());
    return view;
}

class CorpusTest : public testing::TestWithParam<std::string> {};

TEST_P(CorpusTest, Survives) {
    const auto check = viewCheckOf("survival", GetParam());
    for (const auto& file : corpus()) {
        const auto verdict = check->check(viewIn(file));
        EXPECT_EQ(verdict.kind, Kind::measured) << file << ' ' << verdict.text;
    }
}

TEST_P(CorpusTest, IsLikeTheReference) {
    const auto check = viewCheckOf("difference", GetParam());
    for (const auto& file : corpus(GetParam() != "egl")) {
        const auto verdict = check->check(viewIn(file));
        ASSERT_NE(verdict.kind, Kind::broken) << file << ' ' << verdict.text;
        if (verdict.kind != Kind::measured) continue;
        EXPECT_GE(verdict.psnr, 45.0) << file;
    }
}

TEST(Corpus, HasTheSameBytes) {
    const auto check = viewCheckOf("bytes", "cpu");
    for (const auto& file : corpus()) {
        const auto verdict = check->check(viewIn(file));
        ASSERT_EQ(verdict.kind, Kind::measured) << file << ' ' << verdict.text;
        EXPECT_LE(verdict.worst, 1) << file << ' ' << verdict.text;
    }
}

INSTANTIATE_TEST_SUITE_P(All, CorpusTest, testing::ValuesIn(drawerKinds()),
                         [](const auto& kind) { return kind.param; });

}  // namespace
}  // namespace mote::test
