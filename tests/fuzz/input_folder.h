// SPDX-License-Identifier: GPL-3.0-or-later
//
// Inputs of several files, and the folder that they are written to. Any thread.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

namespace mote::test {

/// A folder that goes with its files; in memory, where the machine has such a place.
class InputFolder {
  public:
    InputFolder();
    ~InputFolder();
    InputFolder(const InputFolder&) = delete;
    InputFolder& operator=(const InputFolder&) = delete;

    void write(const std::string& name, std::string_view bytes) const;
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

/// Whether it names a file within the folder, and nothing else.
bool isPlainName(std::string_view name);

/// Files one after the other, each "NAME SIZE\n" and its bytes, by their names; 32 at most. Those that are
/// none of a file in a folder are left out; a size beyond the end means up to it.
std::map<std::string, std::string> filesOf(std::string_view input);

}  // namespace mote::test
