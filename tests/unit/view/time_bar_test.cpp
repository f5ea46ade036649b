// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/time_bar.h"

#include <gmock/gmock.h>

namespace mote::client {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class LoadedStepsTest : public testing::Test {
  protected:
    void look(double now, std::uint64_t view, const std::string& dataset = "data/beam") {
        proto::Frame picture;
        picture.set_view_id(view);
        picture.set_sequence(view);
        loaded_.look(now, dataset, view > 0 ? &picture : nullptr,
                     [this](const std::string& of, Connection::Reply<proto::Loaded> reply) {
                         asked_.push_back(of);
                         replies_.push_back(std::move(reply));
                     });
    }
    void answer(std::initializer_list<std::uint32_t> steps) {
        proto::Loaded loaded;
        loaded.mutable_steps()->Add(steps.begin(), steps.end());
        replies_.back()(loaded);
    }

    LoadedSteps loaded_;
    std::vector<std::string> asked_;
    std::vector<Connection::Reply<proto::Loaded>> replies_;
};

TEST_F(LoadedStepsTest, AreAskedForAsPicturesComeAndNotAtRest) {
    look(0.0, 0);
    EXPECT_THAT(asked_, IsEmpty()) << "nothing is shown";
    look(0.1, 1);
    EXPECT_EQ(asked_.size(), 1U);
    look(0.2, 2);
    look(5.0, 2);
    EXPECT_EQ(asked_.size(), 1U) << "one question at a time";
    answer({7, 3});
    EXPECT_THAT(loaded_.steps(), ElementsAre(3U, 7U));
    EXPECT_TRUE(loaded_.holds(7));
    EXPECT_FALSE(loaded_.holds(4));
    look(5.1, 2);
    EXPECT_EQ(asked_.size(), 2U) << "of the picture that came meanwhile";
    answer({3});
    look(5.2, 3);
    EXPECT_EQ(asked_.size(), 2U) << "too soon";
    look(5.2 + LoadedSteps::pause, 3);
    EXPECT_EQ(asked_.size(), 3U);
    answer({3});
    for (int second = 6; second < 100; ++second) look(second, 3);
    EXPECT_EQ(asked_.size(), 3U) << "at rest";
}

TEST_F(LoadedStepsTest, AnotherDatasetHasNoneUntilItIsAskedFor) {
    look(0.0, 1);
    answer({1, 2});
    look(1.0, 1, "data/ct");
    EXPECT_THAT(loaded_.steps(), IsEmpty());
    look(2.0, 2, "data/beam");
    answer({5});  // of the other one
    EXPECT_THAT(loaded_.steps(), IsEmpty());
    look(3.0, 2);
    EXPECT_THAT(asked_, ElementsAre("data/beam", "data/ct", "data/beam"));
    replies_.back()(Error{ErrorCode::notFound, "dataset", "is gone"});
    EXPECT_THAT(loaded_.steps(), IsEmpty());
}

}  // namespace
}  // namespace mote::client
