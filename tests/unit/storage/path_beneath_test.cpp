// SPDX-License-Identifier: GPL-3.0-or-later
//
// A dataset that was found beneath its root, of which a folder or a file gives its place to a link that leads
// out before it is opened. What lies outside is a copy, byte for byte: no hash tells it from the dataset.
#include "storage/files/path_beneath.h"

#include <fcntl.h>
#include <gmock/gmock.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <optional>
#include <thread>

#include "storage/catalogue.h"
#include "storage/manifest.h"
#include "storage/particles/particle_step.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/storage/old_kernel.h"
#include "tests/unit/storage/tiny_dataset.h"

namespace mote::storage {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class SwappedDatasetTest : public testing::Test {
  protected:
    void SetUp() override {
        fs::create_directory(dir / "sub");
        test::TinyDataset().write(dir / "sub" / "a.mote");
        fs::copy(dir.path(), outside.path(), fs::copy_options::recursive);
        ASSERT_TRUE(catalogue.refresh());
        found = *catalogue.find("data/sub/a");
    }

    /// Opens the dataset that was found; why it cannot be, or nothing.
    std::optional<Error> open() const {
        const auto manifest = readManifest(found.directory);
        if (!manifest.ok()) return manifest.error();
        const auto step = ParticleStep::open(found.directory, *manifest, 0);
        if (!step.ok()) return step.error();
        return std::nullopt;
    }

    /// Each part of the dataset's path in turn is a link that leads out while `look` is called.
    void swapEach(const std::function<void(const fs::path& part)>& look) {
        for (const char* part :
             {"sub", "sub/a.mote", "sub/a.mote/manifest.json", "sub/a.mote/manifest.digest",
              "sub/a.mote/step-000000.digest", "sub/a.mote/step-000000.h5"}) {
            fs::rename(real / part, outside / "aside");
            fs::create_symlink(outside / part, real / part);
            look(real / part);
            fs::remove(real / part);
            fs::rename(outside / "aside", real / part);
            EXPECT_FALSE(open().has_value()) << part << " is back";
        }
    }

    const test::TempDir dir, outside;
    const fs::path real = fs::canonical(dir.path());
    Catalogue catalogue{*Roots::parse({"data=" + dir.path().string()})};
    Catalogue::Entry found;
};

TEST_F(SwappedDatasetTest, LeadsNowhere) {
    swapEach([&](const fs::path& part) {
        const auto error = open();
        ASSERT_TRUE(error.has_value()) << part;
        EXPECT_EQ(error->code, ErrorCode::corrupt) << error->toString();
        EXPECT_THAT(error->where, testing::StartsWith(part.string()));
        EXPECT_THAT(error->message, HasSubstr("is a link or lies behind one"));
    });
}

TEST_F(SwappedDatasetTest, LeadsNowhereWithoutOpenat2) {
    std::thread old([this] {
        ASSERT_TRUE(test::forgetOpenat2());
        swapEach([&](const fs::path& part) {
            const auto error = open();
            ASSERT_TRUE(error.has_value()) << part;
            EXPECT_THAT(error->where, testing::StartsWith(part.string()));
        });
    });
    old.join();
}

TEST_F(SwappedDatasetTest, IsNotListed) {
    swapEach([&](const fs::path& part) {
        catalogue.refresh();
        const bool folder = part.extension() == "" || part.extension() == ".mote";
        const bool read = part.stem() == "manifest";
        EXPECT_EQ(catalogue.entries().empty(), folder || read) << part;
        EXPECT_EQ(catalogue.errors().empty(), !read) << part;
    });
    catalogue.refresh();
    EXPECT_EQ(catalogue.entries().size(), 1U);
}

TEST_F(SwappedDatasetTest, OpenFoldersStayWhatTheyAre) {
    const auto folder = found.directory.open(O_PATH | O_DIRECTORY);
    swapEach([&](const fs::path& part) {
        if (part.extension() != ".mote" && part.extension() != "") return;
        const auto manifest = readManifest(PathBeneath::in(folder, "the dataset"));
        EXPECT_TRUE(manifest.ok()) << part;
    });
    fs::remove(real / "sub" / "a.mote" / manifestName);
    EXPECT_EQ(readManifest(PathBeneath::in(folder, "the dataset")).error().where,
              "the dataset/manifest.json");
}

/// What another program holds by a lease is not waited for: it may never let go of it.
TEST_F(SwappedDatasetTest, AFileUnderALeaseIsRefusedAtOnce) {
    const FileDescriptor holder(::open((real / "sub" / "a.mote" / manifestName).c_str(), O_RDWR | O_CLOEXEC));
    const auto ignored = std::signal(SIGIO, SIG_IGN);  // who asks for it
    if (::fcntl(holder.get(), F_SETLEASE, F_WRLCK) != 0) GTEST_SKIP() << "there are no leases here";
    const auto begun = std::chrono::steady_clock::now();
    const auto manifest = readManifest(found.directory);
    EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(10));
    ASSERT_FALSE(manifest.ok());
    EXPECT_EQ(manifest.error().code, ErrorCode::resourceExhausted);
    EXPECT_TRUE(manifest.error().passing);
    Catalogue other(*Roots::parse({"data=" + dir.path().string()}));
    other.refresh();
    EXPECT_EQ(other.entries().size(), 0U);
    EXPECT_EQ(::fcntl(holder.get(), F_SETLEASE, F_UNLCK), 0);
    other.refresh();
    EXPECT_EQ(other.entries().size(), 1U);
    std::signal(SIGIO, ignored);
}

/// Who names a dataset on a command line may do so by a link.
TEST_F(SwappedDatasetTest, ThePathThatAUserGivesIsTrusted) {
    fs::create_directory_symlink(outside / "sub", dir / "mine");
    const auto dataset = dir / "mine" / "a.mote";
    fs::create_directory_symlink(dataset, dir / "link.mote");
    for (const auto& path : {dataset, dir / "link.mote"}) {
        const auto manifest = readManifest(path);
        ASSERT_TRUE(manifest.ok()) << manifest.error().toString();
        EXPECT_TRUE(ParticleStep::open(path, *manifest, 0).ok());
    }
}

}  // namespace
}  // namespace mote::storage
