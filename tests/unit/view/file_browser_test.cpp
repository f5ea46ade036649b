// SPDX-License-Identifier: GPL-3.0-or-later
//
// Files without a server and without a window: pages, what is searched and sorted, what is asked and ended,
// and that what is drawn does not grow with the folder.
#include "client/view/datasets/file_browser.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <imgui.h>

#include <algorithm>

#include "tests/unit/view/unseen_frames.h"

namespace mote::client {
namespace {

using testing::ElementsAre;
using FileColumn = FolderList::Column;

proto::Folder pageOf(const std::string& folder, int first, int count, int total) {
    proto::Folder page;
    page.set_folder(folder);
    page.set_first(static_cast<std::uint64_t>(first));
    page.set_total(static_cast<std::uint64_t>(total));
    for (int i = first; i < first + count; ++i) {
        auto& entry = *page.add_entries();
        entry.set_name(fmt::format("run_{}.h5", i));
        entry.set_kind(proto::Folder::FILE);
        entry.set_bytes(static_cast<std::uint64_t>((i * 7919) % 10007));
        entry.set_changed_ms(1 + (i * 104729) % 10007);
    }
    return page;
}

TEST(FolderList, PagesJoinAndAnotherFolderReplacesThem) {
    FolderList list;
    list.take(pageOf("data/a", 0, 10, 25));
    EXPECT_FALSE(list.complete());
    list.take(pageOf("data/b", 10, 10, 25));  // of a folder that is not asked for any more
    list.take(pageOf("data/a", 20, 5, 25));   // out of order
    EXPECT_EQ(list.entries().size(), 10U);
    list.take(pageOf("data/a", 10, 15, 25));
    EXPECT_TRUE(list.complete());
    EXPECT_EQ(list.find("", FileColumn::name, false).size(), 25U);
    list.take(pageOf("data/b", 0, 2, 2));
    EXPECT_EQ(list.folder(), "data/b");
    EXPECT_EQ(list.find("", FileColumn::name, false).size(), 2U);
    list.take(pageOf("data/b", 2, 0, 9));  // what has gone meanwhile is not waited for
    EXPECT_TRUE(list.complete());
}

TEST(FolderList, FindsWhatHoldsAllWordsInTheOrderOfAColumn) {
    FolderList list;
    list.take(pageOf("data", 0, 1000, 1000));
    EXPECT_THAT(list.find("RUN 99 .h5", FileColumn::name, false),
                ElementsAre(99, 199, 299, 399, 499, 599, 699, 799, 899, 990, 991, 992, 993, 994, 995, 996,
                            997, 998, 999));
    for (const bool descending : {false, true}) {
        auto bySize = list.find("", FileColumn::size, descending);
        if (descending) std::ranges::reverse(bySize);
        EXPECT_TRUE(std::ranges::is_sorted(
            bySize, {}, [&](int at) { return list.entries()[static_cast<std::size_t>(at)].bytes(); }));
        auto byTime = list.find("", FileColumn::changed, descending);
        if (descending) std::ranges::reverse(byTime);
        EXPECT_TRUE(std::ranges::is_sorted(
            byTime, {}, [&](int at) { return list.entries()[static_cast<std::size_t>(at)].changed_ms(); }));
    }
    EXPECT_EQ(list.find("", FileColumn::name, true).front(), 999);
}

/// A server whose answers a test gives, and frames of Dear ImGui that nothing shows.
class FileBrowserTest : public testing::Test {
  protected:
    FileBrowserTest() {
        FileLine line;
        line.list = [this](const std::string& folder, std::uint64_t first,
                           FileLine::Reply<proto::Folder> reply) {
            listed_.push_back(fmt::format("{}:{}", folder, first));
            folders_.push_back(std::move(reply));
        };
        line.look = [this](const proto::LookAtFile& wanted, FileLine::Reply<proto::Look> reply) {
            looked_.push_back(wanted.input());
            looks_.push_back(std::move(reply));
            return std::uint64_t{looked_.size()};
        };
        line.cancel = [this](std::uint64_t look) { cancelled_.push_back(look); };
        line.whyNot = [this] { return whyNot_; };
        browser_.emplace(std::move(line));
        browser_->begin();
    }

    std::optional<FileBrowser::Choice> frame() {
        ImGui::NewFrame();
        ImGui::SetNextWindowPos({10.0F, 10.0F});
        ImGui::SetNextWindowSize({930.0F, 600.0F});
        ImGui::Begin("files");
        auto choice = browser_->draw(1.0F);
        ImGui::End();
        ImGui::Render();
        return choice;
    }
    std::optional<FileBrowser::Choice> frames(int count = 4) {
        std::optional<FileBrowser::Choice> choice;
        for (; count > 0; --count) {
            auto now = frame();
            if (now) choice = std::move(now);
        }
        return choice;
    }
    /// A key goes down, and up again.
    std::optional<FileBrowser::Choice> key(ImGuiKey key, bool ctrl = false) {
        auto& io = ImGui::GetIO();
        io.KeyMap[key] = static_cast<int>(key) + 1;
        const auto at = static_cast<std::size_t>(io.KeyMap[key]);
        io.KeyCtrl = ctrl;
        if (ctrl) io.KeyMods = ImGuiKeyModFlags_Ctrl;
        io.KeysDown[at] = true;
        auto choice = frames(2);
        io.KeysDown[at] = false;
        io.KeyCtrl = false;
        io.KeyMods = 0;
        auto after = frames(2);
        return choice ? choice : after;
    }
    /// Nothing comes for a while.
    void rest() {
        ImGui::GetIO().DeltaTime = 1.0F;
        frames(2);
        ImGui::GetIO().DeltaTime = 1.0F / 60.0F;
    }
    void type(const char* letters) {
        ImGui::GetIO().AddInputCharactersUTF8(letters);
        frames(2);
    }
    static int vertices() { return ImGui::GetDrawData()->TotalVtxCount; }

    const test::UnseenFrames frames_{1280.0F, 720.0F};
    std::string whyNot_;
    std::vector<std::string> listed_, looked_;
    std::vector<FileLine::Reply<proto::Folder>> folders_;
    std::vector<FileLine::Reply<proto::Look>> looks_;
    std::vector<std::uint64_t> cancelled_;
    std::optional<FileBrowser> browser_;
};

proto::Folder rootsOf(std::initializer_list<const char*> names) {
    proto::Folder roots;
    for (const char* name : names) {
        roots.add_entries()->set_name(name);
        roots.mutable_entries(roots.entries_size() - 1)->set_kind(proto::Folder::FOLDER);
    }
    roots.set_total(names.size());
    return roots;
}

proto::Look lookOf(const std::string& input) {
    proto::Look look;
    look.set_input(input);
    auto& found = *look.add_found();
    found.set_kind("particles");
    (*found.mutable_facts()->mutable_fields())["axes"].set_string_value("x,px,y");
    return look;
}

TEST_F(FileBrowserTest, AllPagesOfTheOnlyRootAreAskedForAndNoMoreIsDrawnThanSeen) {
    frames();
    EXPECT_THAT(listed_, ElementsAre(":0"));
    folders_[0](rootsOf({"data"}));
    ASSERT_THAT(listed_, ElementsAre(":0", "data:0"));
    folders_[1](pageOf("data", 0, 30, 30));
    frames();
    const int few = vertices();
    EXPECT_GT(few, 1000);
    browser_->begin();
    folders_[2](pageOf("data", 0, 5000, 10000));
    folders_[3](pageOf("data", 5000, 5000, 10000));
    EXPECT_EQ(listed_.back(), "data:5000");
    frames();
    EXPECT_LT(std::abs(vertices() - few), 300);
}

TEST_F(FileBrowserTest, KeysChooseAFileAndMakeADatasetOfIt) {
    frames();
    folders_[0](rootsOf({"data", "more"}));
    frames();
    EXPECT_THAT(listed_, ElementsAre(":0")) << "of two roots one is chosen";
    key(ImGuiKey_DownArrow);
    key(ImGuiKey_Enter);
    ASSERT_EQ(listed_.back(), "more:0");
    folders_[1](pageOf("more", 0, 300, 300));
    frames();
    type("run_27.h5");
    key(ImGuiKey_Enter);
    EXPECT_THAT(looked_, ElementsAre("more/run_27.h5"));
    EXPECT_FALSE(key(ImGuiKey_Enter, true).has_value()) << "nothing is known of it yet";
    looks_[0](lookOf("more/run_27.h5"));
    frames();
    const auto choice = key(ImGuiKey_Enter, true);
    ASSERT_TRUE(choice && choice->job);
    EXPECT_EQ(choice->job->output(), "more/run_27.mote");
    EXPECT_EQ(choice->job->particles().inputs(0), "more/run_27.h5");
    EXPECT_TRUE(cancelled_.empty());
}

TEST_F(FileBrowserTest, AnotherFileAndTheEndOfThePageEndALook) {
    frames();
    folders_[0](rootsOf({"data"}));
    folders_[1](pageOf("data", 0, 3, 3));
    frames();
    key(ImGuiKey_Enter);
    key(ImGuiKey_DownArrow);
    key(ImGuiKey_Enter);
    EXPECT_THAT(looked_, ElementsAre("data/run_0.h5", "data/run_1.h5"));
    EXPECT_THAT(cancelled_, ElementsAre(1U));
    looks_[0](lookOf("data/run_0.h5"));  // which nobody waits for
    frames();
    EXPECT_FALSE(key(ImGuiKey_Enter, true).has_value());
    browser_->rest();
    EXPECT_THAT(cancelled_, ElementsAre(1U, 2U));
}

TEST_F(FileBrowserTest, ADatasetIsOpenedAndBackspaceGoesUp) {
    frames();
    folders_[0](rootsOf({"data"}));
    proto::Folder page;
    page.set_folder("data");
    page.set_total(2);
    page.add_entries()->set_name("sub");
    page.mutable_entries(0)->set_kind(proto::Folder::FOLDER);
    page.add_entries()->set_name("beam.mote");
    page.mutable_entries(1)->set_kind(proto::Folder::DATASET);
    folders_[1](page);
    frames();
    key(ImGuiKey_DownArrow);
    const auto choice = key(ImGuiKey_Enter);
    ASSERT_TRUE(choice.has_value());
    EXPECT_EQ(choice->dataset, "data/beam");
    EXPECT_FALSE(choice->job.has_value());
    key(ImGuiKey_UpArrow);
    key(ImGuiKey_Enter);
    EXPECT_EQ(listed_.back(), "data/sub:0");
    folders_[2](Error{ErrorCode::notFound, "data/sub", "has gone"});
    frames();
    key(ImGuiKey_Backspace);
    EXPECT_EQ(listed_.back(), "data:0");
}

TEST_F(FileBrowserTest, FilesThatAreFoundAreOneRunOnRequest) {
    frames();
    folders_[0](rootsOf({"data"}));
    folders_[1](pageOf("data", 0, 30, 30));
    frames();
    type("run_1");
    key(ImGuiKey_UpArrow);
    key(ImGuiKey_Enter);
    EXPECT_THAT(looked_, ElementsAre("data/run_1.h5"));
    looks_[0](lookOf("data/run_1.h5"));
    frames();
    const auto choice = key(ImGuiKey_Enter, true);
    ASSERT_TRUE(choice && choice->job);
    EXPECT_EQ(choice->job->output(), "data/run.mote");
    const auto& inputs = choice->job->particles().inputs();
    ASSERT_EQ(inputs.size(), 11);
    EXPECT_EQ(inputs[1], "data/run_10.h5");
    key(ImGuiKey_UpArrow);
    key(ImGuiKey_DownArrow);
    key(ImGuiKey_Enter);
    EXPECT_THAT(looked_, ElementsAre("data/run_1.h5", "data/run_1.h5"))
        << "the file by itself is another thing";
}

TEST_F(FileBrowserTest, WhatIsNotThereIsNotLookedAt) {
    frames();
    folders_[0](rootsOf({"data"}));
    folders_[1](pageOf("data", 0, 3, 3));
    frames();
    type("nothing of this name");
    for (const auto each : {ImGuiKey_DownArrow, ImGuiKey_UpArrow, ImGuiKey_Enter}) key(each);
    rest();
    EXPECT_THAT(looked_, testing::IsEmpty());
    for (int i = 0; i < 20; ++i) key(ImGuiKey_Backspace);
    key(ImGuiKey_DownArrow);
    rest();
    EXPECT_THAT(looked_, ElementsAre("data/run_1.h5")) << "the arrows rest on it";
    for (int i = 0; i < 2; ++i) key(ImGuiKey_UpArrow);
    rest();
    EXPECT_EQ(looked_.size(), 1U) << "a folder is looked at on request alone";
    key(ImGuiKey_Enter);
    EXPECT_EQ(looked_.back(), "data");
}

TEST_F(FileBrowserTest, AnOlderServerIsASentence) {
    whyNot_ = "It is older.";
    EXPECT_FALSE(frames().has_value());
    EXPECT_LT(vertices(), 500);
}

}  // namespace
}  // namespace mote::client
