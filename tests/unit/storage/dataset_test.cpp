// SPDX-License-Identifier: GPL-3.0-or-later
#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <thread>

#include "protocol/base/json.h"
#include "storage/arrays/array_file.h"
#include "storage/catalogue.h"
#include "storage/dataset_writer.h"
#include "storage/files/dataset_file.h"
#include "storage/hash.h"
#include "storage/manifest.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/storage/file_time.h"
#include "tests/unit/storage/forged_digest.h"
#include "tests/unit/storage/tiny_dataset.h"

namespace mote::storage {
namespace {

namespace fs = std::filesystem;
using test::TinyDataset;
using testing::ElementsAre;
using testing::HasSubstr;

std::vector<std::string> namesOf(const Catalogue& catalogue) {
    std::vector<std::string> names;
    for (const auto& entry : catalogue.entries()) names.push_back(entry.name);
    return names;
}

Catalogue catalogueOf(const fs::path& folder) {
    return Catalogue(*Roots::parse({"data=" + folder.string()}));
}

/// Arrays of other lengths than whole blocks, one of them of none, at whatever places HDF5 gives them.
/// `ahead`: they are hashed while others are written, but for the last one, which finish() finds.
void expectOnePass(const fs::path& folder, bool ahead, const std::vector<std::size_t>& order = {0, 1, 2, 3}) {
    const std::vector<std::uint64_t> lengths{5 * blockBytes + 77, 0, 3, 9 * blockBytes};
    FileLayout layout;
    for (std::size_t i = 0; i < lengths.size(); ++i)
        layout.arrays.push_back({fmt::format("/array{}", i), "u8", {lengths[i]}});
    auto file = ArrayFileWriter::create(folder, "a", layout);
    ASSERT_TRUE(file.ok()) << file.error().toString();
    file->passCache();
    if (ahead) file->writeTogether();
    std::atomic<int> asked{0};
    if (ahead) file->hashAhead([&] { return ++asked < 0; });
    std::vector<std::vector<std::byte>> content(lengths.size());
    for (const auto i : order) {
        auto& bytes = content[i];
        bytes.resize(lengths[i]);
        for (std::size_t k = 0; k < bytes.size(); ++k) bytes[k] = static_cast<std::byte>(k * (i + 3) >> 4);
        // In two parts, whose border lies within a page and a block.
        const auto part = std::span(bytes).first(bytes.size() / 2 + 1 - (bytes.empty() ? 1 : 0));
        ASSERT_TRUE(file->write(i, part.size(), std::span(bytes).subspan(part.size())).ok());
        ASSERT_TRUE(file->write(i, 0, part).ok());
        std::vector<std::byte> back(bytes.size());
        ASSERT_TRUE(file->read(i, 0, back).ok());
        EXPECT_TRUE(back == bytes) << i;
        if (i != order.back()) file->complete(i);
    }
    // What is first in the file is hashed without finish().
    for (int i = 0; ahead && order.front() == 0 && asked < 3 && i < 1000; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_EQ(ahead && order.front() == 0, asked >= 3);
    const auto hash = file->finish();
    ASSERT_TRUE(hash.ok()) << hash.error().toString();
    std::ifstream stream(folder / "a.h5", std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(stream), {}};
    EXPECT_EQ(hash->size, whole.size());
    EXPECT_EQ(hash->xxh3_128, hash128(std::as_bytes(std::span(whole))));
    EXPECT_EQ(hashFile(folder / "a.h5")->xxh3_128, hash->xxh3_128);
    proto::Digest digest;
    std::ifstream told(folder / "a.digest");
    const std::string text{std::istreambuf_iterator<char>(told), {}};
    ASSERT_TRUE(parseJson(text, digest, "a.digest").ok());
    for (std::size_t i = 0; i < lengths.size(); ++i) {
        const auto& blocks = digest.arrays(static_cast<int>(i)).blocks();
        ASSERT_EQ(static_cast<std::uint64_t>(blocks.size()), (lengths[i] + blockBytes - 1) / blockBytes);
        for (int block = 0; block < blocks.size(); ++block) {
            const auto at = static_cast<std::size_t>(block) * blockBytes;
            const auto size = std::min<std::uint64_t>(blockBytes, lengths[i] - at);
            EXPECT_EQ(blocks[block], hashBlock(std::span(content[i]).subspan(at, size))) << i << " " << block;
        }
    }
    if (ahead) return;
    const auto stopped = file->finish([] { return true; });
    EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
}

/// A folder in memory alone, of tmpfs; empty where there is none.
class FolderInMemory {
  public:
    FolderInMemory() {
        std::string name = "/dev/shm/mote-test-XXXXXX";
        const FileDescriptor shm(::open("/dev/shm", O_RDONLY | O_DIRECTORY | O_CLOEXEC));
        if (shm.valid() && isInMemory(shm.get()) && ::mkdtemp(name.data()) != nullptr) path_ = name;
    }
    FolderInMemory(const FolderInMemory&) = delete;
    FolderInMemory& operator=(const FolderInMemory&) = delete;
    ~FolderInMemory() {
        std::error_code ignored;
        if (!path_.empty()) fs::remove_all(path_, ignored);
    }
    const fs::path& path() const { return path_; }

  private:
    fs::path path_;
};

TEST(ArrayFileWriter, InMemoryAloneItIsTheSame) {
    const FolderInMemory folder;
    if (folder.path().empty()) GTEST_SKIP() << "/dev/shm is no tmpfs";
    for (const bool ahead : {false, true}) {
        const auto in = folder.path() / (ahead ? "ahead" : "after");
        fs::create_directory(in);
        expectOnePass(in, ahead, {0, 1, 2, 3});
    }
    const auto file = ArrayFileWriter::create(folder.path(), "b", {{}, {{"/a", "u8", {1ULL << 50}}}, {}});
    ASSERT_FALSE(file.ok()) << "more than there can be";
    EXPECT_EQ(file.error().code, ErrorCode::resourceExhausted);
    EXPECT_NE(file.error().message.find("bytes that it needs"), std::string::npos) << file.error().message;
}

TEST(ArrayFileWriter, HashesArraysAheadWhileOthersAreWritten) {
    const test::TempDir dir;
    const std::vector<std::vector<std::size_t>> orders{
        {0, 1, 2, 3}, {0, 3, 1, 2}, {3, 2, 1, 0}, {1, 3, 2, 0}};
    for (std::size_t i = 0; i < orders.size(); ++i) {
        const auto folder = dir / std::to_string(i);
        fs::create_directory(folder);
        expectOnePass(folder, true, orders[i]);
    }
    // Who is given up half-way, or told to stop, leaves no thread behind.
    auto file = ArrayFileWriter::create(dir.path(), "b", {{}, {{"/array", "u8", {blockBytes}}}, {}});
    ASSERT_TRUE(file.ok());
    {
        auto givenUp = *std::move(file);
        givenUp.hashAhead({});
    }
    file = ArrayFileWriter::create(dir.path(), "c", {{}, {{"/array", "u8", {blockBytes}}}, {}});
    ASSERT_TRUE(file.ok());
    file->hashAhead([] { return true; });
    EXPECT_EQ(file->finish().error().code, ErrorCode::cancelled);
}

/// What its owner has of an array is not read back; the rest of it, and others, are.
TEST(ArrayFileWriter, HashesWhatIsHeldWithoutReadingIt) {
    const test::TempDir dir;
    std::vector<std::byte> bytes(6 * blockBytes + 4);
    for (std::size_t k = 0; k < bytes.size(); ++k) bytes[k] = static_cast<std::byte>(k >> 5);
    const FileLayout layout{{}, {{"/read", "u8", {bytes.size()}}, {"/held", "u8", {bytes.size()}}}, {}};
    std::atomic<std::uint64_t> held{0};
    const auto hold = [&](std::size_t array, std::uint64_t at, std::span<std::byte> to) {
        if (array != 1 || at >= 4 * blockBytes) return false;
        std::ranges::copy(std::span(bytes).subspan(at, to.size()), to.begin());
        held += to.size();
        return true;
    };
    std::vector<std::string> found;
    for (const bool holds : {false, true}) {
        const auto name = holds ? "b" : "a";
        auto file = ArrayFileWriter::create(dir.path(), name, layout);
        ASSERT_TRUE(file.ok());
        file->hashAhead({}, holds ? HashPass::Held(hold) : HashPass::Held());
        for (const std::size_t array : {0U, 1U}) ASSERT_TRUE(file->write(array, 0, bytes).ok());
        // The file has other bytes there than its owner, so that the hash tells whose were taken.
        const std::vector<std::byte> other(blockBytes);
        ASSERT_TRUE(!holds || file->write(1, blockBytes, other).ok());
        for (const std::size_t array : {0U, 1U}) file->complete(array);
        const auto hash = file->finish();
        ASSERT_TRUE(hash.ok());
        found.push_back(hash->xxh3_128);
    }
    EXPECT_EQ(found[0], found[1]);
    EXPECT_EQ(held, 4 * blockBytes);
}

TEST(ArrayFileWriter, HashesBlocksAndTheWholeInOnePassOverTheFile) {
    const test::TempDir dir;
    expectOnePass(dir.path(), false);
    // A file system in memory has no way past the cache.
    const fs::path memory = fs::path("/dev/shm") / ("mote-" + dir.path().filename().string());
    std::error_code code;
    if (!fs::create_directory(memory, code)) return;
    expectOnePass(memory, false);
    fs::remove_all(memory);
}

TEST(DatasetWriter, RemovesWhatIsNotPublished) {
    const test::TempDir dir;
    {
        auto writer = DatasetWriter::create(dir / "a.mote");
        ASSERT_TRUE(writer.ok());
        std::ofstream(writer->directory() / "file") << "x";
        EXPECT_TRUE(fs::exists(writer->directory()));
        const DatasetWriter moved = *std::move(writer);
        EXPECT_TRUE(fs::exists(moved.directory()));
    }
    EXPECT_TRUE(fs::is_empty(dir.path()));
}

TEST(DatasetWriter, NeverReplaces) {
    const test::TempDir dir;
    auto writer = DatasetWriter::create(dir / "a.mote");
    ASSERT_TRUE(writer.ok());
    // Another process publishes the same name first, be it an empty folder.
    fs::create_directory(dir / "a.mote");
    std::ofstream(writer->directory() / "step-000000.h5") << "x";
    std::ofstream(writer->directory() / "step-000000.digest") << "x";
    ASSERT_TRUE(writer->add("step-000000.h5").ok());
    ASSERT_TRUE(writer->add("step-000000.digest").ok());
    const auto published = writer->publish(TinyDataset().manifest());
    ASSERT_FALSE(published.ok());
    EXPECT_EQ(published.error().code, ErrorCode::alreadyExists);
    EXPECT_TRUE(fs::is_empty(dir / "a.mote"));
    EXPECT_EQ(DatasetWriter::create(dir / "a.mote").error().code, ErrorCode::alreadyExists);
}

TEST(DatasetWriter, DebrisOfAKilledProcessIsNoObstacle) {
    const test::TempDir dir;
    fs::path debris;
    {
        auto writer = DatasetWriter::create(dir / "a.mote");
        debris = writer->directory();
    }
    fs::create_directory(debris);
    EXPECT_TRUE(DatasetWriter::create(dir / "a.mote").ok());
    EXPECT_TRUE(fs::exists(debris));
    EXPECT_EQ(DatasetWriter::create(dir / "a.other").error().code, ErrorCode::invalidArgument);
    EXPECT_EQ(DatasetWriter::create(dir / ".mote").error().code, ErrorCode::invalidArgument);
}

TEST(DatasetWriter, WhatIsWrittenOnAfterItsHashIsNotPublished) {
    const test::TempDir dir;
    for (const bool written : {true, false}) {
        auto writer = DatasetWriter::create(dir / "a.mote");
        ASSERT_TRUE(writer.ok());
        for (const auto* const name : {"step-000000.h5", "step-000000.digest"}) {
            std::ofstream(writer->directory() / name) << "x";
            ASSERT_TRUE(writer->add(name).ok());
        }
        if (written) std::ofstream(writer->directory() / "step-000000.h5", std::ios::app) << "y";
        const auto published = writer->publish(TinyDataset().manifest());
        EXPECT_EQ(published.ok(), !written);
        EXPECT_EQ(fs::exists(dir / "a.mote"), !written);
        if (written) {
            EXPECT_EQ(published.error().code, ErrorCode::corrupt);
        }
    }
}

TEST(Hash, AgreesWithPublishedVectors) {
    // xxhsum -H2 and -H3 of nothing (XXH3 specification, seed 0).
    EXPECT_EQ(hash128({}), "99aa06d3014798d86001c324468d497f");
    EXPECT_EQ(hashBlock({}), 0x2d06800538d394c2ULL);
}

/// Hashes are those of the plain kind, whatever the processor has: written down as XXH3 in C gives them.
TEST(Hash, IsTheSameByAnyVectors) {
    std::vector<std::byte> bytes;
    for (std::uint32_t i = 0, x = 1; i < blockBytes; ++i) {
        x = x * 1664525U + 1013904223U;
        bytes.push_back(static_cast<std::byte>(x >> 24U));
    }
    const std::vector<std::pair<std::size_t, std::uint64_t>> expected{
        {1, 0x429e81bc6744101cULL},    {17, 0xb5d6b9c1898bd9d6ULL},     {200, 0x85d691776ef97dbeULL},
        {1000, 0xce7f62c0bb515a3cULL}, {100003, 0x48ace114702c07a4ULL}, {blockBytes, 0x6a1e48380a87d1afULL}};
    for (const auto& [size, hash] : expected)
        EXPECT_EQ(hashBlock(std::span(bytes).first(size)), hash) << size;
    for (const std::size_t part : {std::size_t{1}, std::size_t{255}, std::size_t{4096}, bytes.size()}) {
        FileHasher hasher;
        for (std::size_t at = 0; at < bytes.size(); at += part)
            hasher.add(std::span(bytes).subspan(at, std::min(part, bytes.size() - at)));
        EXPECT_EQ(hasher.hash().xxh3_128, hash128(bytes)) << part;
        EXPECT_EQ(hasher.hash().size, bytes.size());
    }
}

TEST(Manifest, RoundTrip) {
    const test::TempDir dir;
    TinyDataset().write(dir / "a.mote");
    const auto manifest = readManifest(dir / "a.mote");
    ASSERT_TRUE(manifest.ok()) << manifest.error().toString();
    EXPECT_EQ(manifest->title(), "tiny");
    EXPECT_EQ(manifest->files_size(), 2);
    EXPECT_EQ(findFile(*manifest, "step-000000.h5")->size(),
              fs::file_size(dir / "a.mote" / "step-000000.h5"));
    EXPECT_EQ(findFile(*manifest, "nothing"), nullptr);
}

TEST(Manifest, EveryFieldThatAProgramReliesOnIsChecked) {
    const test::TempDir dir;
    TinyDataset().write(dir / "a.mote");
    const auto good = *readManifest(dir / "a.mote");
    const auto errorOf = [&](const std::function<void(proto::Manifest&)>& change) {
        auto manifest = good;
        change(manifest);
        const auto checked = checkManifest(manifest);
        return checked.ok() ? Error{ErrorCode::internal, "accepted", ""} : checked.error();
    };
    const auto where = [&](const std::function<void(proto::Manifest&)>& change) {
        return errorOf(change).where;
    };
    EXPECT_EQ(errorOf([](auto& m) { m.set_format(2); }).code, ErrorCode::unsupported);
    EXPECT_EQ(errorOf([](auto& m) { m.set_kind("mesh"); }).code, ErrorCode::unsupported);
    EXPECT_EQ(where([](auto& m) { m.mutable_files(0)->set_name("../x"); }), "files[0].name");
    EXPECT_EQ(where([](auto& m) { m.mutable_files(0)->set_name(".."); }), "files[0].name");
    EXPECT_EQ(where([](auto& m) { m.mutable_files(0)->set_name(m.files(1).name()); }), "files[1].name");
    EXPECT_EQ(where([](auto& m) { m.mutable_files(0)->set_xxh3_128("12"); }), "files[0].xxh3128");
    EXPECT_EQ(where([](auto& m) { m.mutable_particles()->mutable_axes()->RemoveLast(); }), "particles.axes");
    EXPECT_EQ(where([](auto& m) { m.mutable_particles()->mutable_axes(1)->set_max(-2.0); }),
              "particles.axes[1]");
    EXPECT_EQ(where([](auto& m) { m.mutable_particles()->set_density_min(0.0); }), "particles.densityMin");
    EXPECT_EQ(where([](auto& m) { m.mutable_particles()->set_density_max(1.0); }), "particles.densityMin");
    EXPECT_EQ(where([](auto& m) { m.mutable_particles()->set_volume_level(9); }), "particles.volumeLevel");
    EXPECT_EQ(where([](auto& m) { m.mutable_particles()->set_max_level(17); }), "particles.maxLevel");
    EXPECT_EQ(where([](auto& m) { m.mutable_particles()->clear_steps(); }), "particles.steps");
    const auto step = [](proto::Manifest& m) { return m.mutable_particles()->mutable_steps(0); };
    EXPECT_EQ(where([&](auto& m) { step(m)->set_file("/etc/passwd"); }), "particles.steps[0].file");
    EXPECT_EQ(where([&](auto& m) { step(m)->set_particles(1); }), "particles.steps[0].densityHistogram");
    EXPECT_EQ(where([&](auto& m) { step(m)->clear_density_histogram(); }),
              "particles.steps[0].densityHistogram");
    EXPECT_EQ(where([&](auto& m) { step(m)->set_total_weight(-1.0); }), "particles.steps[0].totalWeight");
    const auto ownAxes = [&](proto::Manifest & m) -> auto& {
        return *(*step(m)->mutable_axes() = m.particles().axes()).Mutable(1);
    };
    EXPECT_EQ(where([&](auto& m) { ownAxes(m).set_max(3.0); }), "accepted");
    EXPECT_EQ(where([&](auto& m) { ownAxes(m).set_max(-2.0); }), "particles.steps[0].axes[1]");
    EXPECT_EQ(where([&](auto& m) { ownAxes(m).set_name("pz"); }), "particles.steps[0].axes");
    EXPECT_EQ(where([&](auto& m) { ownAxes(m), step(m)->mutable_axes()->RemoveLast(); }),
              "particles.steps[0].axes");
}

TEST(Manifest, ABrokenFileIsCorrupt) {
    const test::TempDir dir;
    TinyDataset().write(dir / "a.mote");
    const auto path = dir / "a.mote" / manifestName;
    test::forgeManifest(dir / "a.mote", "{\"kind\": \"particles\", \"sort\": 1}");
    EXPECT_EQ(readManifest(dir / "a.mote").error().code, ErrorCode::corrupt);
    EXPECT_THAT(readManifest(dir / "a.mote").error().toString(), HasSubstr("sort"));
    // A pipe in its place must not make anybody wait.
    fs::remove(path);
    ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
    EXPECT_EQ(readManifest(dir / "a.mote").error().code, ErrorCode::corrupt);
    EXPECT_EQ(readManifest(dir / "b.mote").error().code, ErrorCode::notFound);
}

TEST(Manifest, NoChangedBitIsTaken) {
    const test::TempDir dir;
    TinyDataset().write(dir / "a.mote");
    const auto path = dir / "a.mote" / manifestName;
    std::string text;
    std::getline(std::ifstream(path), text, char(0));
    for (std::size_t i = 0; i < text.size(); ++i) {
        auto changed = text;
        changed[i] = static_cast<char>(changed[i] ^ (1 << (i % 8)));
        std::ofstream(path, std::ios::binary) << changed;
        ASSERT_EQ(readManifest(dir / "a.mote").error().code, ErrorCode::corrupt) << i;
    }
    std::ofstream(path, std::ios::binary) << text;
    EXPECT_TRUE(readManifest(dir / "a.mote").ok());
    // One of a dataset that was made before there were any.
    fs::remove(dir / "a.mote" / manifestDigestName);
    EXPECT_TRUE(readManifest(dir / "a.mote").ok());
}

TEST(Catalogue, ListsFindsAndNotices) {
    const test::TempDir dir;
    fs::create_directories(dir / "plots" / "deep");
    auto catalogue = catalogueOf(dir.path());
    EXPECT_TRUE(catalogue.entries().empty());
    EXPECT_FALSE(catalogue.refresh());
    TinyDataset().write(dir / "b.mote");
    TinyDataset().write(dir / "plots" / "deep" / "a.mote");
    std::ofstream(dir / "file.mote") << "a file is no dataset";
    EXPECT_TRUE(catalogue.refresh());
    EXPECT_THAT(namesOf(catalogue), ElementsAre("data/b", "data/plots/deep/a"));
    EXPECT_TRUE(catalogue.errors().empty());
    const auto* entry = catalogue.find("data/plots/deep/a");
    ASSERT_NE(entry, nullptr);
    EXPECT_EQ(entry->directory.path(), fs::canonical(dir.path()) / "plots" / "deep" / "a.mote");
    EXPECT_EQ(catalogue.find("data/b.mote"), catalogue.find("data/b"));
    EXPECT_EQ(catalogue.find("data/c"), nullptr);
    EXPECT_EQ(catalogue.find(""), nullptr);
    EXPECT_EQ(catalogue.summary().datasets(0).title(), "tiny");
    EXPECT_EQ(catalogue.summary().datasets(1).particles(), TinyDataset::points);
    // All that lies in the folder but the manifest's own digest, and when the manifest was written.
    const auto folder = dir / "plots" / "deep" / "a.mote";
    std::uintmax_t bytes = 0;
    for (const auto& file : fs::directory_iterator(folder))
        bytes += file.path().filename() == manifestDigestName ? 0 : file.file_size();
    EXPECT_EQ(catalogue.summary().datasets(1).bytes(), bytes);
    struct stat status {};
    ASSERT_EQ(::stat((folder / manifestName).c_str(), &status), 0);
    EXPECT_EQ(catalogue.summary().datasets(1).prepared_ms() / 1000, status.st_mtim.tv_sec);
    // Nothing changed: the same manifests, not read again.
    const auto kept = entry->manifest;
    EXPECT_FALSE(catalogue.refresh());
    EXPECT_EQ(catalogue.find("data/plots/deep/a")->manifest, kept);
    fs::remove_all(dir / "b.mote");
    EXPECT_TRUE(catalogue.refresh());
    EXPECT_THAT(namesOf(catalogue), ElementsAre("data/plots/deep/a"));
}

TEST(Catalogue, AManifestIsReadAgainThoughItsTimeAndSizeArePutBack) {
    const test::TempDir dir;
    TinyDataset().write(dir / "a.mote");
    auto catalogue = catalogueOf(dir.path());
    ASSERT_TRUE(catalogue.refresh());
    const auto file = dir / "a.mote" / manifestName;
    const auto before = fs::last_write_time(file);
    test::awaitNextTime(file);
    std::string text;
    std::getline(std::ifstream(file), text, char(0));
    const auto title = text.find("tiny");
    ASSERT_NE(title, std::string::npos);
    test::forgeManifest(dir / "a.mote", text.replace(title, 4, "TINY"));
    fs::last_write_time(file, before);
    EXPECT_TRUE(catalogue.refresh());
    EXPECT_EQ(catalogue.summary().datasets(0).title(), "TINY");
}

TEST(Catalogue, AManifestIsReadAgainWhenItsDigestChanges) {
    const test::TempDir dir;
    TinyDataset().write(dir / "a.mote");
    auto catalogue = catalogueOf(dir.path());
    ASSERT_TRUE(catalogue.refresh());
    const auto file = dir / "a.mote" / manifestDigestName;
    std::string digest;
    std::getline(std::ifstream(file), digest, char(0));
    auto other = digest;
    other[0] = other[0] == '0' ? '1' : '0';
    test::awaitNextTime(file);
    std::ofstream(file) << other;
    EXPECT_TRUE(catalogue.refresh());
    EXPECT_TRUE(catalogue.entries().empty());
    EXPECT_EQ(catalogue.errors().size(), 1U);
    test::awaitNextTime(file);
    std::ofstream(file) << digest;
    EXPECT_TRUE(catalogue.refresh());
    EXPECT_EQ(catalogue.entries().size(), 1U);
    EXPECT_TRUE(catalogue.errors().empty());
}

TEST(Catalogue, FoldersThatComeAndGoHideNoOther) {
    constexpr int datasets = 60;
    const test::TempDir dir;
    TinyDataset().write(dir / "first.mote");
    std::vector<std::string> names{"data/first"};
    for (int i = 0; i < datasets; ++i) {
        const auto folder = fmt::format("folder{}", i % 7);
        fs::create_directories(dir / folder);
        fs::copy(dir / "first.mote", dir / folder / fmt::format("set{}.mote", i),
                 fs::copy_options::recursive);
        names.push_back(fmt::format("data/{}/set{}", folder, i));
    }
    std::sort(names.begin(), names.end());
    std::atomic<bool> done{false};
    std::jthread others([&] {
        for (int i = 0; !done; ++i) {
            const auto draft = dir / fmt::format("folder{}", i % 7) / fmt::format("draft{}", i);
            fs::create_directories(draft / "a" / "b");
            fs::create_directories(dir / fmt::format("new{}.mote.partial-{}", i % 3, i));
            fs::remove_all(draft);
            fs::remove_all(dir / fmt::format("new{}.mote.partial-{}", i % 3, i));
        }
    });
    auto catalogue = catalogueOf(dir.path());
    for (int look = 0; look < 200; ++look) {
        catalogue.refresh();
        ASSERT_EQ(namesOf(catalogue), names) << "look " << look;
        ASSERT_TRUE(catalogue.errors().empty()) << catalogue.errors()[0].toString();
    }
    done = true;
}

TEST(Catalogue, ABrokenDatasetIsReportedAndTheRestListed) {
    const test::TempDir dir;
    TinyDataset().write(dir / "good.mote");
    TinyDataset().write(dir / "bad.mote");
    std::ofstream(dir / "bad.mote" / manifestName) << "{";
    fs::create_directory(dir / "empty.mote");
    fs::create_directory(dir / "other.mote.partial-1");
    fs::create_directory_symlink("good.mote", dir / "link.mote");
    fs::create_directory_symlink(".", dir / "loop");
    auto catalogue = catalogueOf(dir.path());
    EXPECT_TRUE(catalogue.refresh());
    EXPECT_THAT(namesOf(catalogue), ElementsAre("data/good"));
    ASSERT_EQ(catalogue.errors().size(), 2U);
    // Repaired, it appears.
    fs::remove_all(dir / "bad.mote");
    TinyDataset().write(dir / "bad.mote");
    EXPECT_TRUE(catalogue.refresh());
    EXPECT_THAT(namesOf(catalogue), ElementsAre("data/bad", "data/good"));
    EXPECT_EQ(catalogue.errors().size(), 1U);
}

TEST(Catalogue, DepthIsBounded) {
    const test::TempDir dir;
    fs::path folder = dir.path();
    for (int i = 0; i < Catalogue::maxDepth; ++i) folder /= "d";
    fs::create_directories(folder / "d");
    TinyDataset().write(folder / "in.mote");
    TinyDataset().write(folder / "d" / "out.mote");
    auto catalogue = catalogueOf(dir.path());
    catalogue.refresh();
    EXPECT_THAT(namesOf(catalogue), ElementsAre("data/d/d/d/d/d/d/d/d/in"));
}

TEST(Catalogue, ARootThatVanishedIsReported) {
    const test::TempDir dir;
    fs::create_directory(dir / "data");
    auto catalogue = catalogueOf(dir / "data");
    fs::remove(dir / "data");
    EXPECT_FALSE(catalogue.refresh());
    EXPECT_EQ(catalogue.errors().size(), 1U);
}

}  // namespace
}  // namespace mote::storage
