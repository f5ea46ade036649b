// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/save_json.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>
#include <sstream>

#include "protocol/mote.pb.h"
#include "protocol/scene/json.h"
#include "tests/support/temp_dir.h"

namespace mote::client {
namespace {

proto::View viewOf(unsigned width) {
    proto::View view;
    view.set_width(width);
    view.add_layers()->set_dataset(std::string(20000, 'd'));
    return view;
}

std::string textOf(const std::filesystem::path& path) {
    std::ostringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    return text.str();
}

class SaveJson : public testing::Test {
  protected:
    /// Nothing hidden is left beside them.
    std::size_t files() const {
        const std::filesystem::directory_iterator all(folder_.path());
        return static_cast<std::size_t>(std::distance(begin(all), end(all)));
    }

    test::TempDir folder_;
    const std::filesystem::path path_ = folder_ / "view.json";
};

TEST_F(SaveJson, WritesWhatIsRead) {
    ASSERT_TRUE(saveJson(path_, viewOf(7), SameName::stays).ok());
    EXPECT_EQ(textOf(path_), toJson(viewOf(7)));
    EXPECT_EQ(files(), 1U);
}

TEST_F(SaveJson, LeavesWhatIsThereUnlessItIsToBeReplaced) {
    std::ofstream(path_) << "mine";
    const auto refused = saveJson(path_, viewOf(7), SameName::stays);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::alreadyExists);
    EXPECT_EQ(textOf(path_), "mine");
    EXPECT_EQ(files(), 1U);
    ASSERT_TRUE(saveJson(path_, viewOf(7), SameName::isReplaced).ok());
    EXPECT_EQ(textOf(path_), toJson(viewOf(7)));
}

TEST_F(SaveJson, LeavesALinkThatLeadsNowhere) {
    std::filesystem::create_symlink("nowhere", path_);
    EXPECT_EQ(saveJson(path_, viewOf(7), SameName::stays).error().code, ErrorCode::alreadyExists);
    EXPECT_TRUE(std::filesystem::is_symlink(path_));
}

TEST_F(SaveJson, AFullDiskLeavesWhatWasThere) {
    std::ofstream(path_) << "mine";
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit small{4096, before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    const auto saved = saveJson(path_, viewOf(7), SameName::isReplaced);
    ::setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
    ASSERT_FALSE(saved.ok());
    EXPECT_FALSE(saved.error().message.empty());
    EXPECT_EQ(textOf(path_), "mine");
    EXPECT_EQ(files(), 1U);
}

TEST_F(SaveJson, SaysWhereItCannotWrite) {
    EXPECT_EQ(saveJson(folder_ / "none" / "view.json", viewOf(7), SameName::stays).error().code,
              ErrorCode::notFound);
    EXPECT_EQ(saveJson(folder_.path(), viewOf(7), SameName::isReplaced).error().code,
              ErrorCode::alreadyExists);
}

}  // namespace
}  // namespace mote::client
