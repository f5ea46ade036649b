// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/dataset_service.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace mote::server
