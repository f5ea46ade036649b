// SPDX-License-Identifier: GPL-3.0-or-later
//
// Folders beneath a root: their order, their pages, and that no name and no link leads out.
#include "server/jobs/look/list_folder.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <vector>

#include "tests/support/random.h"
#include "tests/support/temp_dir.h"

namespace mote::server {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class ListFolder : public testing::Test {
  protected:
    ListFolder() {
        std::filesystem::create_directories(folder_ / "root/sub");
        roots_ = *storage::Roots::parse({"data=" + (folder_ / "root").string()});
    }
    void touch(const std::string& name) const { std::ofstream(folder_ / "root" / name) << "123"; }
    Result<proto::Folder> list(const std::string& name, std::uint64_t first = 0,
                               std::uint32_t count = 0) const {
        proto::ListFolder wanted;
        wanted.set_folder(name);
        wanted.set_first(first);
        wanted.set_count(count);
        return listFolder(wanted, roots_);
    }
    std::vector<std::string> names(const std::string& folder, std::uint64_t first = 0,
                                   std::uint32_t count = 0) const {
        const auto listed = list(folder, first, count);
        EXPECT_TRUE(listed.ok()) << listed.error().toString();
        std::vector<std::string> names;
        for (const auto& entry : listed->entries()) names.push_back(entry.name());
        return names;
    }

    test::TempDir folder_;
    storage::Roots roots_;
};

TEST_F(ListFolder, FoldersComeFirstAndNumbersByTheirValue) {
    for (const char* name : {"run_10.h5", "run_9.h5", "Run_2.h5", ".hidden", "b.mote.partial-12ab"})
        touch(name);
    std::filesystem::create_directories(folder_ / "root/b.mote");
    std::filesystem::create_directories(folder_ / "root/c.mote");
    std::ofstream(folder_ / "root/c.mote/manifest.json") << "{}";
    EXPECT_THAT(names("data"), ElementsAre("b.mote", "sub", "c.mote", "Run_2.h5", "run_9.h5", "run_10.h5"));
    const auto listed = *list("data");
    EXPECT_EQ(listed.entries(0).kind(), proto::Folder::FOLDER) << "a folder that is called like a dataset";
    EXPECT_EQ(listed.entries(2).kind(), proto::Folder::DATASET);
    EXPECT_EQ(listed.entries(3).kind(), proto::Folder::FILE);
    EXPECT_EQ(listed.entries(3).bytes(), 3U);
    EXPECT_GT(listed.entries(3).changed_ms(), 1'000'000'000'000);
    EXPECT_THAT(listed.notes(), IsEmpty());
    EXPECT_THAT(names(""), ElementsAre("data"));
}

TEST_F(ListFolder, PagesAreThoseOfTheWhole) {
    for (int i = 0; i < 25; ++i) touch("sub/" + std::to_string(i));
    const auto whole = names("data/sub");
    ASSERT_EQ(whole.size(), 25U);
    std::vector<std::string> pages;
    for (std::uint64_t first = 0; first < 30; first += 7) {
        EXPECT_EQ(list("data/sub", first, 7)->total(), 25U);
        for (auto& name : names("data/sub", first, 7)) pages.push_back(name);
    }
    EXPECT_EQ(pages, whole);
    EXPECT_THAT(names("data/sub", ~std::uint64_t{0}, ~std::uint32_t{0}), IsEmpty());
}

TEST_F(ListFolder, OfAHugeFolderABoundedNumberIsRead) {
    const auto path = folder_ / "root/sub";
    const auto more = static_cast<int>(mostFolderNames) + 5;
    for (int i = 0; i < more; ++i) std::filesystem::create_symlink("../run", path / std::to_string(i));
    touch("run");
    const auto listed = *list("data/sub");
    EXPECT_EQ(listed.total(), mostFolderNames);
    EXPECT_EQ(static_cast<std::size_t>(listed.entries_size()), mostListed);
    ASSERT_EQ(listed.notes_size(), 1);
    EXPECT_THAT(listed.notes(0), testing::HasSubstr("more than 100000 names"));
}

TEST_F(ListFolder, WhatIsNeitherFileNorFolderIsLeftOutAndSaid) {
    const auto at = [this](const char* name) { return folder_ / "root/sub" / name; };
    ASSERT_EQ(::mkfifo(at("pipe").c_str(), 0600), 0);
    std::filesystem::create_symlink("/etc", at("out"));
    std::filesystem::create_symlink("loop", at("loop"));
    std::filesystem::create_symlink("../sub", at("in"));
    touch("sub/\xff");
    EXPECT_THAT(names("data/sub"), ElementsAre("in"));
    EXPECT_THAT(list("data/sub")->notes(),
                ElementsAre("a name that is not UTF-8 is left out",
                            "2 links that lead out of the root, or nowhere, are left out",
                            "something that is neither a file nor a folder is left out"));
    EXPECT_THAT(names("data/sub/in/in"), ElementsAre("in"));
}

TEST_F(ListFolder, WrongNamesAreErrorsThatSayNoPathOfThisMachine) {
    touch("file");
    std::filesystem::create_symlink("/etc", folder_ / "root/out");
    const auto code = [this](const std::string& name) {
        const auto listed = list(name);
        EXPECT_FALSE(listed.ok()) << name;
        if (listed.ok()) return ErrorCode::internal;
        EXPECT_EQ(listed.error().toString().find(folder_.path().string()), std::string::npos);
        return listed.error().code;
    };
    for (const char* name :
         {"data/..", "data/sub/..", "data/", "/etc", "..", "data//sub", "data/out", "data/file"})
        EXPECT_EQ(code(name), ErrorCode::invalidArgument) << name;
    EXPECT_EQ(code(std::string("data/a\0b", 8)), ErrorCode::invalidArgument);
    EXPECT_EQ(code("data/none"), ErrorCode::notFound);
    EXPECT_EQ(code("other"), ErrorCode::notFound);
}

TEST(StandsBefore, IsAnOrder) {
    test::Random random(21);
    std::vector<std::string> names;
    for (int i = 0; i < 200; ++i) {
        std::string name;
        for (std::uint64_t letters = random.below(6); letters > 0; --letters)
            name += random.oneOf({"0", "1", "9", "10", "007", "a", "A", "b", "_", "\xc3\xa4"});
        names.push_back(name);
    }
    for (const auto& a : names) {
        EXPECT_FALSE(standsBefore(a, a));
        for (const auto& b : names) {
            EXPECT_EQ(standsBefore(a, b) || standsBefore(b, a), a != b) << a << " " << b;
            EXPECT_FALSE(standsBefore(a, b) && standsBefore(b, a)) << a << " " << b;
            for (const auto& c : names)
                ASSERT_TRUE(!standsBefore(a, b) || !standsBefore(b, c) || standsBefore(a, c)) << a << b << c;
        }
    }
    EXPECT_TRUE(standsBefore("run_9", "RUN_10"));
    EXPECT_TRUE(standsBefore("run_007", "run_8"));
}

}  // namespace
}  // namespace mote::server
