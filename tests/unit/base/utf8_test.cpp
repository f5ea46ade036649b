// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/base/utf8.h"

#include <gtest/gtest.h>

#include <new>
#include <random>
#include <stdexcept>

#include "protocol/base/complain.h"

namespace mote {
namespace {

TEST(TerminalText, WhatATerminalWouldObeyIsShownInstead) {
    EXPECT_EQ(toTerminalText("a\x1b[2Jb"), "a\\x1b[2Jb");
    EXPECT_EQ(toTerminalText("\x1b]52;c;cm0gLXJm\x07"), "\\x1b]52;c;cm0gLXJm\\x07");  // sets the clipboard
    EXPECT_EQ(toTerminalText("\xc2\x9d"
                             "0;title\xc2\x9c"),
              "\\x9d"
              "0;title\\x9c");  // the same in C1
    EXPECT_EQ(toTerminalText("overwritten\rby this\b\x7f"), "overwritten\\x0dby this\\x08\\x7f");
    EXPECT_EQ(toTerminalText("\x9b"
                             "31m"),
              "?31m");  // C1 as one byte, which is no UTF-8
    EXPECT_EQ(toTerminalText("two\nlines"), "two\\x0alines");
    EXPECT_EQ(toTerminalLines("two\n\tlines\x1b"), "two\n\tlines\\x1b");
}

TEST(TerminalText, OtherTextIsKept) {
    for (const std::string text : {"", "Bündel, 5 µm", "\xe2\x82\xac \xf0\x9f\x98\x80 ~", "C:\\x1b"}) {
        EXPECT_EQ(toTerminalText(text), text);
        EXPECT_EQ(toTerminalLines(text), text);
    }
}

bool holdsControl(std::string_view text, bool lines) {
    while (!text.empty()) {
        const auto length = characterLength(text);
        const auto first = static_cast<unsigned char>(text[0]);
        const bool c1 = length == 2 && first == 0xc2 && static_cast<unsigned char>(text[1]) < 0xa0;
        const bool c0 = first < 0x20 && !(lines && (first == '\n' || first == '\t'));
        if (length == 0 || c0 || c1 || first == 0x7f) return true;
        text.remove_prefix(length);
    }
    return false;
}

TEST(TerminalText, NoBytesLeaveAControlCharacter) {
    std::mt19937_64 random(20261123);
    const std::string_view likely("\x1b\xc2\x80\x9f\x9b\xe2\x82\xac\n\r\t]P\\\x07\x7f\xf0", 17);
    for (int turn = 0; turn < 20000; ++turn) {
        std::string text(random() % 40, '\0');
        for (auto& c : text)
            c = random() % 2 ? likely[random() % likely.size()] : static_cast<char>(random());
        EXPECT_FALSE(holdsControl(toTerminalText(text), false));
        EXPECT_FALSE(holdsControl(toTerminalLines(text), true));
        EXPECT_FALSE(holdsControl(toLogText(text), false));
        EXPECT_LE(toLogText(text).size(), text.size());
    }
}

TEST(Complaint, AtTheEndOfAProgramTakesNoMemoryWhereThereIsNone) {
    testing::internal::CaptureStderr();
    complainAtEnd("mote-prep", std::bad_alloc());
    complainAtEnd("mote-prep", std::runtime_error("a\rb"));
    EXPECT_EQ(testing::internal::GetCapturedStderr(),
              "mote-prep: there is not enough memory\nmote-prep: a\\x0db\n");
}

}  // namespace
}  // namespace mote
