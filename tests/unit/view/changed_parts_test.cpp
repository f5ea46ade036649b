// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/changed_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "tests/support/random.h"
#include "tests/unit/view/unseen_frames.h"

namespace mote::client {
namespace {

constexpr int width = 160, height = 120;

/// Windows with boxes and letters in them, of which some change from frame to frame.
class Interface {
  public:
    explicit Interface(std::uint64_t seed) : random_(91, seed) {
        for (auto& window : windows_) {
            for (auto& box : window.boxes) change(box);
        }
    }

    ImDrawData& draw() {
        ImGui::NewFrame();
        for (std::size_t i = 0; i < windows_.size(); ++i) drawWindow(i);
        ImGui::Render();
        return *ImGui::GetDrawData();
    }

    void changeSomething() {
        const auto which = static_cast<std::size_t>(random_.unit() * windows_.size());
        auto& window = windows_[which];
        const double what = random_.unit();
        if (what < 0.6) {
            change(window.boxes[static_cast<std::size_t>(random_.unit() * window.boxes.size())]);
        } else if (what < 0.75) {
            window.words = std::string(static_cast<std::size_t>(random_.unit() * 9.0), 'm');
        } else if (what < 0.9) {
            window.shown = !window.shown;
        } else if (window.shown) {
            ImGui::SetWindowFocus(nameOf(which).c_str());
        }
    }

  private:
    const test::UnseenFrames frames_{width, height};
    struct Box {
        float left, top, right, bottom;
        ImU32 color;
    };
    struct Window {
        std::array<Box, 4> boxes{};
        std::string words = "mm";
        bool shown = true;
    };

    static std::string nameOf(std::size_t window) { return "window " + std::to_string(window); }

    void change(Box& box) {
        const auto at = [&] { return static_cast<float>(random_.between(0.0, 70.0)); };
        box = {at(), at(), 0.0F, 0.0F, IM_COL32(255 * random_.unit(), 90, 200, 255 * random_.unit())};
        box.right = box.left + at();
        box.bottom = box.top + at();
    }

    void drawWindow(std::size_t i) {
        const auto& window = windows_[i];
        if (!window.shown) return;
        const ImVec2 at{17.3F * static_cast<float>(i), 11.6F * static_cast<float>(i)};
        ImGui::SetNextWindowPos(at);
        ImGui::SetNextWindowSize({90.5F, 70.0F});
        ImGui::Begin(nameOf(i).c_str(), nullptr, ImGuiWindowFlags_NoDecoration);
        ImGui::TextUnformatted(window.words.c_str());
        for (const auto& box : window.boxes)
            ImGui::GetWindowDrawList()->AddRectFilled({at.x + box.left, at.y + box.top},
                                                      {at.x + box.right, at.y + box.bottom}, box.color, 4.0F);
        ImGui::End();
    }

    test::Random random_;
    std::array<Window, 4> windows_;
};

int first(float a, float b, float c) {
    return std::max(static_cast<int>(std::min({a, b, c})), 0);
}

/// Beyond it nothing is covered.
int last(int most, float a, float b, float c) {
    return std::clamp(static_cast<int>(std::max({a, b, c})) + 1, 0, most);
}

/// Of each pixel a number that tells what was drawn on it, and in which order.
std::vector<std::uint64_t> drawnOn(const ImDrawData& data) {
    std::vector<std::uint64_t> pixels(width * height, 0);
    for (int i = 0; i < data.CmdListsCount; ++i) {
        const auto& list = *data.CmdLists[i];
        for (const auto& command : list.CmdBuffer) {
            const auto& clip = command.ClipRect;
            for (unsigned e = 0; e < command.ElemCount; e += 3) {
                std::array<ImDrawVert, 3> corners{};
                for (unsigned k = 0; k < 3; ++k)
                    corners[k] = list.VtxBuffer[static_cast<int>(
                        list.IdxBuffer[static_cast<int>(command.IdxOffset + e + k)] + command.VtxOffset)];
                std::uint64_t hash = 14695981039346656037ULL;
                const auto* bytes = reinterpret_cast<const unsigned char*>(corners.data());
                for (std::size_t b = 0; b < sizeof corners; ++b) hash = (hash ^ bytes[b]) * 1099511628211ULL;
                const auto& [a, b, c] = corners;
                const auto side = [](const ImVec2& p, const ImVec2& q, float x, float y) {
                    return (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x);
                };
                for (int row = first(a.pos.y, b.pos.y, c.pos.y);
                     row < last(height, a.pos.y, b.pos.y, c.pos.y); ++row) {
                    for (int column = first(a.pos.x, b.pos.x, c.pos.x);
                         column < last(width, a.pos.x, b.pos.x, c.pos.x); ++column) {
                        const float x = static_cast<float>(column) + 0.5F, y = static_cast<float>(row) + 0.5F;
                        if (x < clip.x || x > clip.z || y < clip.y || y > clip.w) continue;
                        const float s = side(a.pos, b.pos, x, y), t = side(b.pos, c.pos, x, y),
                                    u = side(c.pos, a.pos, x, y);
                        const bool within = (s >= 0 && t >= 0 && u >= 0) || (s <= 0 && t <= 0 && u <= 0);
                        if (!within || (s == 0 && t == 0 && u == 0)) continue;
                        auto& pixel = pixels[static_cast<std::size_t>(row * width + column)];
                        pixel = pixel * 6364136223846793005ULL + hash;
                    }
                }
            }
        }
    }
    return pixels;
}

bool holds(const WindowPart& part, int column, int row) {
    return column >= part.left && column < part.right && row >= part.top && row < part.bottom;
}

TEST(ChangedParts, HoldWhateverIsDrawnOtherwise) {
    long long told = 0, frames = 0, changed = 0;
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
        Interface interface(seed);
        ChangedParts parts;
        EXPECT_FALSE(parts.take(interface.draw()).has_value());  // all of it
        auto before = drawnOn(interface.draw());
        parts.take(*ImGui::GetDrawData());
        for (int frame = 0; frame < 20; ++frame) {
            interface.changeSomething();
            auto& data = interface.draw();
            const auto found = parts.take(data);
            ASSERT_TRUE(found.has_value());
            const auto now = drawnOn(data);
            for (int pixel = 0; pixel < width * height; ++pixel) {
                const int column = pixel % width, row = pixel / width;
                const auto at = static_cast<std::size_t>(pixel);
                changed += now[at] != before[at] ? 1 : 0;
                if (now[at] == before[at]) continue;
                const bool held = std::any_of(found->begin(), found->end(),
                                              [&](const auto& part) { return holds(part, column, row); });
                ASSERT_TRUE(held) << "seed " << seed << ", frame " << frame << ": " << column << ", " << row;
            }
            for (const auto& part : *found) told += part.pixels();
            before = now;
            ++frames;
        }
    }
    EXPECT_GT(changed, 20 * frames);
    EXPECT_LT(told, frames * width * height / 3);  // not simply all of it
}

TEST(ChangedParts, AreNoneWhereNothingChanges) {
    Interface interface(5);
    ChangedParts parts;
    interface.draw();
    parts.take(interface.draw());
    EXPECT_TRUE(parts.take(interface.draw()).value().empty());
    parts.touch(ImGui::GetIO().Fonts->TexID);  // all letters and boxes are drawn by it
    EXPECT_FALSE(parts.take(interface.draw()).value().empty());
    EXPECT_TRUE(parts.take(interface.draw()).value().empty());
    parts.forget();
    EXPECT_FALSE(parts.take(interface.draw()).has_value());
    ImGui::GetIO().DisplaySize.x += 1.0F;
    EXPECT_FALSE(parts.take(interface.draw()).has_value());
}

/// As Dear ImGui's backend cuts: ends are whole pixels, rounded towards the window's upper left or its left
/// and lower ends.
bool leaves(const ImVec4& clip, int column, int row) {
    if (clip.z <= clip.x || clip.w <= clip.y) return false;
    const int left = static_cast<int>(clip.x), bottom = height - static_cast<int>(height - clip.w);
    return column >= left && column < left + static_cast<int>(clip.z - clip.x) && row < bottom &&
           row >= bottom - static_cast<int>(clip.w - clip.y);
}

TEST(ChangedParts, ClipsLeaveInAPartWhatTheyLeft) {
    Interface interface(6);
    test::Random random(92);
    interface.draw();
    auto& data = interface.draw();
    std::vector<ImVec4> own;
    for (int i = 0; i < data.CmdListsCount; ++i) {
        for (auto& command : data.CmdLists[i]->CmdBuffer) {
            const auto by = [&] { return static_cast<float>(random.unit()); };
            command.ClipRect.x += by();
            command.ClipRect.y += by();
            command.ClipRect.z += by();
            command.ClipRect.w += by();
            own.push_back(command.ClipRect);
        }
    }
    for (int turn = 0; turn < 20; ++turn) {
        const int left = static_cast<int>(random.between(0, width - 20)),
                  top = static_cast<int>(random.between(0, height - 20));
        const WindowPart part{left, top, left + 15, top + 18};
        const auto kept = ChangedParts::clipTo(data, part);
        std::size_t k = 0;
        for (int i = 0; i < data.CmdListsCount; ++i) {
            for (const auto& command : data.CmdLists[i]->CmdBuffer) {
                for (int pixel = 0; pixel < width * height; ++pixel) {
                    const int column = pixel % width, row = pixel / width;
                    ASSERT_EQ(leaves(command.ClipRect, column, row),
                              holds(part, column, row) && leaves(own[k], column, row));
                }
                ++k;
            }
        }
        ChangedParts::restoreClips(data, kept);
        k = 0;
        for (int i = 0; i < data.CmdListsCount; ++i) {
            for (const auto& command : data.CmdLists[i]->CmdBuffer) {
                const auto &now = command.ClipRect, &was = own[k++];
                EXPECT_TRUE(now.x == was.x && now.y == was.y && now.z == was.z && now.w == was.w);
            }
        }
    }
}

}  // namespace
}  // namespace mote::client
