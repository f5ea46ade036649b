// SPDX-License-Identifier: GPL-3.0-or-later
//
// Commands: all that a key or a few letters can ask of the viewer, in one list: keys are looked up in it, the
// palette (Ctrl-K) searches it, and the list of keys (?) shows it. Main thread, within a Dear ImGui frame.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace mote::client {

struct Command {
    const char* group;  ///< "Camera"
    std::string name;   ///< "Look from +x"
    std::string keys;   ///< "Ctrl+Shift+Z", as a pressed key is called; empty: none
    std::function<void()> run;
    bool repeats = false;  ///< while the key stays down
};

// What is typed to find something by.

std::string loweredLetters(std::string_view text);
std::vector<std::string> loweredWords(std::string_view typed);
/// Whether a text of lower case holds each of them.
bool holdsAll(const std::string& text, const std::vector<std::string>& words);

/// Those whose names hold all words that were typed, those first that begin with the first one.
std::vector<const Command*> findCommands(const std::vector<Command>& commands, std::string_view typed);

/// A line in which a command is searched by its name, with those that are found below.
class CommandPalette {
  public:
    void open() { opening_ = true; }
    /// It has the keyboard.
    bool isOpen() const { return open_ || opening_; }
    /// Draws it while it is open; the command that the user wants.
    const Command* draw(const std::vector<Command>& commands, float scale);

  private:
    const Command* drawList(const std::vector<const Command*>& found, bool entered);

    std::array<char, 128> typed_{};
    std::string before_;  // what the list is of
    int chosen_ = 0;
    bool opening_ = false, open_ = false;
};

/// A window with all commands that have keys, and what the mouse does.
void drawKeys(bool& shown, const std::vector<Command>& commands, float scale);

}  // namespace mote::client
