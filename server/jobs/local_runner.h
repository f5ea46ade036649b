// SPDX-License-Identifier: GPL-3.0-or-later
//
// LocalRunner: runs mote-prep on this machine, under mote-supervise, which has a session of its own, takes
// rights away from mote-prep, waits for it and writes its result. Owned by the queue and used on its thread.
#pragma once

#include "server/jobs/runner.h"

namespace asio {
class io_context;
}

namespace mote::server {

class LocalRunner final : public Runner {
  public:
    /// Programs as paths. The context outlives the runner and its runs.
    LocalRunner(asio::io_context& context, std::filesystem::path supervisor, std::filesystem::path prep);

    Result<std::unique_ptr<Run>> start(const RunOrder& order) override;
    std::unique_ptr<Run> find(std::string_view handle) override;

  private:
    asio::io_context& context_;
    std::filesystem::path supervisor_;
    std::filesystem::path prep_;
};

}  // namespace mote::server
