// SPDX-License-Identifier: GPL-3.0-or-later
//
// UnseenFrames: Dear ImGui with a screen of a size and letters, and no window: frames that nothing shows. One
// at a time; one thread.
#pragma once

#include <imgui.h>

namespace mote::test {

class UnseenFrames {
  public:
    UnseenFrames(float width, float height) {
        ImGui::CreateContext();
        auto& io = ImGui::GetIO();
        io.IniFilename = nullptr;
        io.DisplaySize = {width, height};
        io.DeltaTime = 1.0F / 60.0F;
        unsigned char* pixels = nullptr;
        int columns = 0, rows = 0;
        io.Fonts->GetTexDataAsRGBA32(&pixels, &columns, &rows);
    }
    ~UnseenFrames() { ImGui::DestroyContext(); }
    UnseenFrames(const UnseenFrames&) = delete;
    UnseenFrames& operator=(const UnseenFrames&) = delete;
};

}  // namespace mote::test
