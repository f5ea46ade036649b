// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/dataset_service.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <new>

#include "tests/support/temp_dir.h"
#include "tests/unit/storage/tiny_dataset.h"

namespace mote::server {
namespace {

template <class Answer>
class Waiting {
  public:
    Asker<Answer> asker() {
        return {[this](Answer answer) { answer_.set_value(std::move(answer)); }, [] {}};
    }
    Answer get() { return answer_.get_future().get(); }

  private:
    std::promise<Answer> answer_;
};

class DatasetServiceTest : public testing::Test {
  protected:
    DatasetServiceTest() { test::TinyDataset().write(dir_ / "a.mote"); }

    Status rescan() {
        Waiting<Status> waiting;
        service_.rescan(waiting.asker());
        return waiting.get();
    }
    Result<proto::Description> describe(const std::string& dataset) {
        Waiting<Result<proto::Description>> waiting;
        service_.describe(dataset, waiting.asker());
        return waiting.get();
    }

    test::TempDir dir_;
    std::atomic<bool> short_{false};  // of memory, at the end of each look
    DatasetService service_{*storage::Roots::parse({"data=" + dir_.path().string()}),
                            [this] {
                                if (short_) throw std::bad_alloc();
                            },
                            std::uint64_t{1} << 28, [] {}};
};

TEST_F(DatasetServiceTest, WorkThatMemoryDoesNotSufficeForEndsNothing) {
    std::promise<void> lost;
    service_.rescan({[](const Status&) { throw std::bad_alloc(); }, [&] { lost.set_value(); }});
    EXPECT_EQ(lost.get_future().wait_for(std::chrono::seconds(30)), std::future_status::ready)
        << "who waits is not left waiting";
    const auto what = describe("data/a");
    ASSERT_TRUE(what.ok()) << what.error().toString();
    EXPECT_EQ(what->dataset(), "data/a");
}

TEST_F(DatasetServiceTest, WhoWaitsHearsOfTheEndThoughMemoryWasShortForAWhile) {
    int tries = 0;
    std::promise<void> told;
    service_.rescan({[&](const Status&) {
                         if (++tries < 3) throw std::bad_alloc();
                         told.set_value();
                     },
                     [] { ADD_FAILURE() << "it was told"; }});
    EXPECT_EQ(told.get_future().wait_for(std::chrono::seconds(30)), std::future_status::ready);
}

TEST_F(DatasetServiceTest, ALookThatMemoryDoesNotSufficeForIsAnErrorForWhoWaitsForIt) {
    short_ = true;
    const auto looked = rescan();
    ASSERT_FALSE(looked.ok());
    EXPECT_EQ(looked.error().code, ErrorCode::resourceExhausted);
    const auto what = describe("data/none");
    ASSERT_FALSE(what.ok());
    EXPECT_EQ(what.error().code, ErrorCode::resourceExhausted) << "nobody knows that it is not there";
    short_ = false;
    EXPECT_TRUE(rescan().ok());
    EXPECT_EQ(describe("data/none").error().code, ErrorCode::notFound);
}

TEST_F(DatasetServiceTest, ThatDatasetsChangedIsToldThoughMemoryWasShort) {
    test::TempDir dir;
    test::TinyDataset().write(dir / "a.mote");
    int tries = 0;
    DatasetService service(
        *storage::Roots::parse({"data=" + dir.path().string()}),
        [&] {
            if (++tries < 3) throw std::bad_alloc();
        },
        std::uint64_t{1} << 28, [] {});
    Waiting<Status> waiting;
    service.rescan(waiting.asker());
    EXPECT_TRUE(waiting.get().ok());
    EXPECT_EQ(tries, 3);
}

}  // namespace
}  // namespace mote::server
