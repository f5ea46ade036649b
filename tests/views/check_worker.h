// SPDX-License-Identifier: GPL-3.0-or-later
//
// CheckWorker: a check in a process of its own, so that a view that ends it ends nothing else: this program
// once more, which reads a view a line and answers with a verdict a line. It is started when it is first
// asked, and again after an end. One owner, one thread.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "tests/views/view_check.h"

namespace mote::test {

class CheckWorker final : public ViewCheck {
  public:
    /// `arguments`: of the program, so that it serves (serveChecks). Its errors go where ours do.
    explicit CheckWorker(std::vector<std::string> arguments) : arguments_(std::move(arguments)) {}
    ~CheckWorker() override;
    CheckWorker(const CheckWorker&) = delete;
    CheckWorker& operator=(const CheckWorker&) = delete;

  private:
    Verdict examine(const proto::View& view) override;
    void start();
    /// How it ended.
    std::string end();
    bool writeLine(const std::string& line) const;
    /// False where it ended, or took longer than anything may.
    bool readLine(std::string& line);

    std::vector<std::string> arguments_;
    pid_t process_ = -1;
    int toIt_ = -1, fromIt_ = -1;
    std::string unread_;
};

/// Reads views from stdin and answers on stdout, until stdin ends.
void serveChecks(ViewCheck& check);

}  // namespace mote::test
