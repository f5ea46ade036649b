// SPDX-License-Identifier: GPL-3.0-or-later
//
// ConsoleProgress: a job's progress as a bar on a terminal, or as one JSON line a change (proto::JobProgress)
// on a descriptor for the program that started the job. Notes go to stderr. Owned by main; any thread may
// report.
#pragma once

#include <mutex>
#include <string>

#include "preprocess/cancel_signal.h"
#include "preprocess/progress.h"

namespace mote::prep {

class ConsoleProgress final : public Progress {
  public:
    struct Options {
        bool quiet = false;       ///< neither bar nor notes
        int lineDescriptor = -1;  ///< where JSON lines go; -1: nowhere
    };

    ConsoleProgress(const CancelSignal& signal, Options options);
    /// Takes the bar away.
    ~ConsoleProgress() override;

    void report(double fraction, std::string_view phase) override;
    void note(std::string_view sentence) override;
    bool cancelled() const override { return signal_.received() != 0; }

  private:
    void writeLine();
    void drawBar() const;
    void clearBar() const;

    const CancelSignal& signal_;
    Options options_;
    bool bar_;  ///< stderr is a terminal and wanted
    std::mutex mutex_;
    double fraction_ = 0.0;
    int percent_ = -1;
    std::string phase_;
};

}  // namespace mote::prep
