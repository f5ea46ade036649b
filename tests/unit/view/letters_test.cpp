// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/letters.h"

#include <gtest/gtest.h>
#include <imgui.h>

#include <filesystem>

#include "protocol/mote.pb.h"

namespace mote::client {
namespace {

class LettersTest : public testing::Test {
  protected:
    LettersTest() { ImGui::CreateContext(); }
    ~LettersTest() override { ImGui::DestroyContext(); }

    bool hasFont() const {
        return std::filesystem::exists("/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf");
    }
    bool draws(char32_t letter) const {
        return ImGui::GetIO().Fonts->Fonts[0]->FindGlyphNoFallback(static_cast<ImWchar>(letter)) != nullptr;
    }

    Letters letters;
};

TEST_F(LettersTest, OfOtherScriptsAreThereOnceLearned) {
    if (!hasFont()) GTEST_SKIP() << "fonts-dejavu-core is not installed";
    letters.build(14.0F);
    EXPECT_TRUE(draws(U'a') && draws(U'µ'));
    EXPECT_FALSE(draws(U'Ω') || draws(U'ж'));
    proto::Catalogue catalogue;
    catalogue.add_datasets()->set_name("data/Ω");
    catalogue.mutable_datasets(0)->set_title("пучок жук");
    letters.learn(catalogue);
    EXPECT_TRUE(letters.isStale());
    letters.build(14.0F);
    EXPECT_FALSE(letters.isStale());
    for (const char32_t letter : U"aµΩпучокж") EXPECT_TRUE(letter == 0 || draws(letter));
    EXPECT_FALSE(draws(U'щ'));
    letters.learn(catalogue);
    EXPECT_FALSE(letters.isStale());
}

TEST_F(LettersTest, OfFurtherFontsAreMergedWhereThereAreAny) {
    letters.learn("束流 ビーム 빔");
    letters.build(14.0F);
    EXPECT_TRUE(draws(U'a'));
    if (Letters::furtherFonts().empty())
        GTEST_SKIP() << "no font of Chinese, Japanese or Korean is installed";
    EXPECT_TRUE(draws(U'束'));
}

TEST_F(LettersTest, WhatIsNoTextIsLeftOut) {
    for (const char* text :
         {"\xC3", "\xE6\x9D", "\xFF\xFE", "\x80\x80", "\xC0\xAF", "\xF8\x88\x80\x80\x80", "\xED\xA0\x80"}) {
        letters.learn(text);
        EXPECT_FALSE(letters.isStale()) << text;
    }
    letters.learn("\xE6\x9D\xE6\x9D\x9F");  // a letter that breaks off, and a whole one
    letters.build(14.0F);
}

TEST_F(LettersTest, ThereAreNotMoreThanATextureHolds) {
    for (char32_t letter = 0x4E00; letter < 0x4E00 + 2 * Letters::most; ++letter) letters.learn(letter);
    letters.build(56.0F);
    EXPECT_LE(ImGui::GetIO().Fonts->TexHeight, 16384);
    letters.learn(U'Ω');
    EXPECT_FALSE(letters.isStale());
}

}  // namespace
}  // namespace mote::client
