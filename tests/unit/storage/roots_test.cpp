// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/roots.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <fstream>
#include <thread>

#include "storage/files/real_path.h"
#include "storage/files/walk_folders.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/storage/old_kernel.h"

namespace mote::storage {
namespace {

namespace fs = std::filesystem;

class RootsTest : public testing::Test {
  protected:
    void SetUp() override {
        fs::create_directories(dir / "data" / "sub" / "deep");
        fs::create_directories(dir / "outside");
        std::ofstream(dir / "data" / "run.h5") << "run";
        std::ofstream(dir / "outside" / "secret") << "secret";
        fs::create_directory_symlink("../outside", dir / "data" / "way-out");
        fs::create_directory_symlink(dir / "outside", dir / "data" / "absolute-way-out");
        fs::create_directory_symlink("sub", dir / "data" / "inside-link");
        fs::create_symlink("nowhere", dir / "data" / "dangling");
        fs::create_directory_symlink("/proc/self/root", dir / "data" / "magic");
        auto parsed = Roots::parse({"data=" + (dir / "data").string()});
        ASSERT_TRUE(parsed.ok());
        roots = *parsed;
        real = fs::canonical(dir.path());
    }

    ErrorCode existing(std::string_view name) { return codeOf(roots.resolveExisting(name)); }
    ErrorCode fresh(std::string_view name) { return codeOf(roots.resolveNew(name)); }
    static ErrorCode codeOf(const Result<fs::path>& result) {
        EXPECT_FALSE(result.ok()) << *result;
        return result.ok() ? ErrorCode::internal : result.error().code;
    }

    test::TempDir dir;
    Roots roots;
    fs::path real;
};

TEST_F(RootsTest, ParsesAndRefuses) {
    const auto folder = (dir / "data").string();
    EXPECT_TRUE(Roots::parse({}).ok());
    EXPECT_EQ(Roots::parse({"a-B_9=" + folder})->entries().front().folder, real / "data");
    for (const auto& text : {std::string("data"), "=" + folder, std::string("data="), "a/b=" + folder,
                             "a b=" + folder, "..=" + folder}) {
        const auto parsed = Roots::parse({text});
        ASSERT_FALSE(parsed.ok()) << text;
        EXPECT_EQ(parsed.error().code, ErrorCode::invalidArgument) << text;
    }
    EXPECT_EQ(Roots::parse({"a=" + (dir / "none").string()}).error().code, ErrorCode::notFound);
    EXPECT_EQ(Roots::parse({"a=" + (dir / "data" / "run.h5").string()}).error().code,
              ErrorCode::invalidArgument);
    EXPECT_EQ(Roots::parse({"a=" + folder, "a=" + folder}).error().code, ErrorCode::invalidArgument);
}

TEST_F(RootsTest, ExistingPathsBeneath) {
    EXPECT_EQ(*roots.resolveExisting("data/run.h5"), real / "data" / "run.h5");
    EXPECT_EQ(*roots.resolveExisting("data/sub/deep"), real / "data" / "sub" / "deep");
    EXPECT_EQ(*roots.resolveExisting("data"), real / "data");
    // A link that stays inside is followed, to its real path.
    EXPECT_EQ(*roots.resolveExisting("data/inside-link/deep"), real / "data" / "sub" / "deep");
    EXPECT_EQ(existing("data/none"), ErrorCode::notFound);
    EXPECT_EQ(existing("data/dangling"), ErrorCode::notFound);
    EXPECT_EQ(existing("data/run.h5/x"), ErrorCode::notFound);
}

TEST_F(RootsTest, NothingLeadsOut) {
    for (const char* name : {"data/../outside/secret", "data/sub/../../outside/secret", "data/way-out/secret",
                             "data/absolute-way-out/secret", "data/magic/etc/passwd", "data//etc/passwd",
                             "data/.", "data/./run.h5", "data/", "data/sub/", "data/..", "/etc/passwd", ""}) {
        const auto resolved = roots.resolveExisting(name);
        ASSERT_FALSE(resolved.ok()) << name << " gave " << *resolved;
        EXPECT_FALSE(roots.resolveNew(name).ok()) << name;
    }
    EXPECT_EQ(existing("data/way-out/secret"), ErrorCode::invalidArgument);
    EXPECT_EQ(existing(std::string_view("data/run.h5\0x", 13)), ErrorCode::invalidArgument);
    EXPECT_EQ(existing("data/" + std::string(5000, 'x')), ErrorCode::invalidArgument);
    EXPECT_EQ(existing("other/run.h5"), ErrorCode::notFound);
    EXPECT_THAT(roots.resolveExisting("other/run.h5").error().message, testing::HasSubstr("data"));
}

TEST_F(RootsTest, WhatLiesBeneathIsNamedAndNotOpened) {
    const auto deep = roots.beneath("data/sub/deep");
    ASSERT_TRUE(deep.ok());
    EXPECT_EQ(deep->path(), real / "data" / "sub" / "deep");
    EXPECT_TRUE(deep->open(O_RDONLY).valid());
    EXPECT_EQ(roots.beneath("data")->path(), real / "data");
    for (const char* name : {"data/way-out/secret", "data/absolute-way-out/secret", "data/inside-link/deep"})
        EXPECT_FALSE(roots.beneath(name)->open(O_RDONLY).valid()) << name;
    EXPECT_EQ(roots.beneath("data/../outside/secret").error().code, ErrorCode::invalidArgument);
    EXPECT_EQ(roots.beneath("other/run.h5").error().code, ErrorCode::notFound);
}

TEST_F(RootsTest, NewPathsNeedAParentAndNothingThere) {
    EXPECT_EQ(*roots.resolveNew("data/new.mote"), real / "data" / "new.mote");
    EXPECT_EQ(*roots.resolveNew("data/inside-link/new.mote"), real / "data" / "sub" / "new.mote");
    EXPECT_EQ(fresh("data/none/new.mote"), ErrorCode::notFound);
    EXPECT_EQ(fresh("data/run.h5"), ErrorCode::alreadyExists);
    EXPECT_EQ(fresh("data/dangling"), ErrorCode::alreadyExists);
    EXPECT_EQ(fresh("data/way-out/new.mote"), ErrorCode::invalidArgument);
    EXPECT_EQ(fresh("data"), ErrorCode::invalidArgument);
}

TEST_F(RootsTest, WithoutOpenat2NoLinkIsFollowed) {
    std::thread old([this] {
        ASSERT_TRUE(test::forgetOpenat2());
        EXPECT_EQ(*roots.resolveExisting("data"), real / "data");
        EXPECT_EQ(*roots.resolveExisting("data/run.h5"), real / "data" / "run.h5");
        EXPECT_EQ(*roots.resolveExisting("data/sub/deep"), real / "data" / "sub" / "deep");
        EXPECT_EQ(*roots.resolveNew("data/sub/new.mote"), real / "data" / "sub" / "new.mote");
        EXPECT_EQ(existing("data/none"), ErrorCode::notFound);
        for (const char* name :
             {"data/way-out/secret", "data/absolute-way-out/secret", "data/magic/etc/passwd",
              "data/inside-link/deep", "data/way-out", "data/dangling"})
            EXPECT_FALSE(roots.resolveExisting(name).ok()) << name;
        EXPECT_FALSE(roots.resolveNew("data/way-out/new.mote").ok());
    });
    old.join();
}

/// A folder and a link that leads out take each other's place 10^4 times, beside whoever looks and opens.
class SwappedLinkTest : public RootsTest {
  protected:
    void SetUp() override {
        RootsTest::SetUp();
        fs::create_directories(dir / "data" / "swap" / "within");
        fs::create_directories(dir / "outside" / "escaped");
        std::ofstream(dir / "data" / "swap" / "file") << "own";
        std::ofstream(dir / "outside" / "file") << "secret";
        fs::create_directory_symlink(dir / "outside", dir / "data" / "link");
    }

    void swap() {
        for (int i = 0; i < 10'000; ++i) {
            fs::rename(dir / "data" / "swap", dir / "data" / "third");
            fs::rename(dir / "data" / "link", dir / "data" / "swap");
            fs::rename(dir / "data" / "third", dir / "data" / "link");
        }
        done_ = true;
    }

    void look() {
        while (!done_) {
            open();
            walk();
        }
    }

    std::atomic<bool> done_{false};

  private:
    void open() const {
        const auto path = roots.resolveExisting("data/swap/file");
        if (!path.ok()) return;
        ASSERT_THAT(path->string(), testing::StartsWith((real / "data").string()));
        const auto file = openReal(*path, O_RDONLY);
        if (!file.ok()) return;
        std::array<char, 16> text{};
        ASSERT_EQ(::read(file->get(), text.data(), text.size()), 3);
        ASSERT_EQ(std::string(text.data()), "own");
    }
    void walk() const {
        FolderWalk folders;
        folders.maxDepth = 3;
        folders.count = [] { return true; };
        folders.unreadable = [](const auto&, int) {};
        folders.visit = [](const fs::path& folder) {
            EXPECT_NE(folder.filename(), "escaped") << folder;
            return FolderWalk::Next::enter;
        };
        walkFolders(real / "data", folders);
    }
};

TEST_F(SwappedLinkTest, LeadsNowhere) {
    std::thread swapper([this] { swap(); });
    look();
    swapper.join();
}

TEST_F(SwappedLinkTest, LeadsNowhereWithoutOpenat2) {
    std::thread swapper([this] { swap(); });
    std::thread old([this] {
        ASSERT_TRUE(test::forgetOpenat2());
        look();
    });
    swapper.join();
    old.join();
}

TEST_F(RootsTest, NamesOfPaths) {
    EXPECT_EQ(roots.nameOf(real / "data" / "sub" / "x.h5"), "data/sub/x.h5");
    EXPECT_EQ(roots.nameOf(real / "data" / "plots" / ".." / "x.h5"), "data/x.h5");
    EXPECT_EQ(roots.nameOf(real / "data"), "data");
    EXPECT_EQ(roots.nameOf(real / "data" / ""), "data");
    EXPECT_EQ(roots.nameOf(real / "outside" / "secret"), std::nullopt);
    EXPECT_EQ(roots.nameOf(real / "data" / ".." / "outside"), std::nullopt);
    EXPECT_EQ(roots.nameOf(real / "database"), std::nullopt);
    EXPECT_EQ(roots.nameOf("data/x"), std::nullopt);
    const auto nested =
        *Roots::parse({"all=" + dir.path().string(), "sub=" + (dir / "data" / "sub").string()});
    EXPECT_EQ(nested.nameOf(real / "data" / "sub" / "x"), "sub/x");
    EXPECT_EQ(nested.nameOf(real / "data" / "x"), "all/data/x");
}

}  // namespace
}  // namespace mote::storage
