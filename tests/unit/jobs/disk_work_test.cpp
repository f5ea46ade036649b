// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which drafts are taken away, and which belong to others.
#include "server/jobs/disk_work.h"

#include <gmock/gmock.h>

#include <future>
#include <set>

#include "tests/support/temp_dir.h"

namespace mote::server {
namespace {

using ::testing::UnorderedElementsAre;

class DiskWorkTest : public testing::Test {
  protected:
    void make(const std::string& name) { std::filesystem::create_directories(folder_ / name / "inside"); }
    std::set<std::string> names() const {
        std::set<std::string> found;
        for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
            found.insert(entry.path().filename().string());
        return found;
    }
    /// Work is done in its order.
    void waitForAll() {
        std::promise<void> done;
        work_.post([&] { done.set_value(); });
        done.get_future().wait();
    }

    test::TempDir folder_;
    const storage::Roots roots_ = *storage::Roots::parse({"data=" + folder_.path().string()});
    DiskWork work_;
};

TEST_F(DiskWorkTest, DraftsOfJobsThatAreOverGoAndThoseOfOthersStay) {
    for (const auto* name :
         {"a.partial-1", "a.partial-2", "a.partial-2.gone-7", "a.partial-99", "a", "b.partial-1"})
        make(name);
    work_.sweepDrafts(roots_,
                      {{"data/a", "1", false}, {"data/a", "2", true}, {"data/missing/x", "3", false}});
    waitForAll();
    EXPECT_THAT(names(), UnorderedElementsAre("a.partial-2", "a.partial-99", "a", "b.partial-1"));
}

TEST_F(DiskWorkTest, ADraftIsOutOfTheWayAtOnce) {
    make("a.partial-1");
    std::promise<void> disk;
    work_.post([held = disk.get_future().share()] { held.wait(); });
    work_.removeDraft(folder_ / "a", "1");
    EXPECT_FALSE(names().contains("a.partial-1"));
    EXPECT_EQ(names().size(), 1U) << "its folder waits for the disk";
    disk.set_value();
    waitForAll();
    EXPECT_THAT(names(), UnorderedElementsAre());
}

}  // namespace
}  // namespace mote::server
