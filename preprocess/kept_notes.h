// SPDX-License-Identifier: GPL-3.0-or-later
//
// KeptNotes: a Progress that passes on what it is told, and keeps the notes for the manifest: each sentence
// once. One owner; note() is asked by one thread at a time.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/job.h"

namespace mote::prep {

class KeptNotes : public Progress {
  public:
    static constexpr std::size_t most = 64;

    explicit KeptNotes(Progress& progress) : progress_(progress) {}
    void report(double fraction, std::string_view phase) override { progress_.report(fraction, phase); }
    bool cancelled() const override { return progress_.cancelled(); }
    void note(std::string_view sentence) override {
        if (std::find(notes_.begin(), notes_.end(), sentence) != notes_.end()) return;
        progress_.note(sentence);
        if (notes_.size() < most) notes_.emplace_back(sentence);
    }
    const std::vector<std::string>& notes() const { return notes_; }

  private:
    Progress& progress_;
    std::vector<std::string> notes_;
};

}  // namespace mote::prep
