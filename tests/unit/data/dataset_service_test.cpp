// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/dataset_service.h"

#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <new>

#include "tests/support/temp_dir.h"
#include "tests/unit/storage/tiny_dataset.h"

namespace mote::server {
namespace {

TEST(DatasetServiceTest, WorkThatMemoryDoesNotSufficeForEndsNothing) {
    const test::TempDir dir;
    test::TinyDataset().write(dir / "a.mote");
    DatasetService service(
        *storage::Roots::parse({"data=" + dir.path().string()}), [] {}, std::uint64_t{1} << 28, [] {});
    service.rescan([] { throw std::bad_alloc(); });
    std::promise<Result<proto::Description>> answer;
    service.describe("data/a", [&](Result<proto::Description> what) { answer.set_value(std::move(what)); });
    const auto what = answer.get_future().get();
    ASSERT_TRUE(what.ok()) << what.error().toString();
    EXPECT_EQ(what->dataset(), "data/a");
}

TEST(DatasetServiceTest, WhoWaitsHearsOfTheEndThoughMemoryWasShortForAWhile) {
    const test::TempDir dir;
    DatasetService service(
        *storage::Roots::parse({"data=" + dir.path().string()}), [] {}, std::uint64_t{1} << 28, [] {});
    int tries = 0;
    std::promise<void> told;
    service.rescan([&] {
        if (++tries < 3) throw std::bad_alloc();
        told.set_value();
    });
    EXPECT_EQ(told.get_future().wait_for(std::chrono::seconds(30)), std::future_status::ready);
}

}  // namespace
}  // namespace mote::server
