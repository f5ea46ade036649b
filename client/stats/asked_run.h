// SPDX-License-Identifier: GPL-3.0-or-later
//
// AskedRun: a dataset of particles of a server, and the questions that mote-stats has for it. Main thread.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "client/shared/numbers.h"
#include "client/shared/server_line.h"
#include "client/stats/options.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::client {

class AskedRun {
  public:
    /// Reads the selection, and asks for the dataset. Errors: invalidArgument, notFound, unsupported (it
    /// holds no particles), with the option that is wrong.
    static Result<AskedRun> open(const StatsOptions& options, ServerLine& server);

    const std::string& dataset() const { return dataset_; }
    const proto::ParticlesManifest& manifest() const { return manifest_; }
    ColumnUnits units() const { return columnUnits(manifest_); }
    /// Those that were chosen, at least one.
    const std::vector<std::size_t>& steps() const { return steps_; }
    const std::optional<proto::Selection>& selection() const { return selection_; }

    /// These, as queries and jobs have them.
    std::string stepsText() const;
    /// A query about the selection in the chosen steps, to which the question itself is to be added.
    proto::Query query() const;
    /// Hands over the answers, one after the other, each for the next of `steps`. Errors: the server's, those
    /// of `take`, which ends the query, corrupt (an answer for another step), cancelled.
    Status ask(const proto::Query& query, const std::vector<std::size_t>& steps,
               const std::function<Status(const QueryAnswer&)>& take);

    ServerLine& server() { return *server_; }

  private:
    AskedRun(ServerLine& server, std::string dataset) : server_(&server), dataset_(std::move(dataset)) {}

    ServerLine* server_;
    std::string dataset_;
    proto::ParticlesManifest manifest_;
    std::vector<std::size_t> steps_;
    std::optional<proto::Selection> selection_;
};

/// Writes the particles of a selection as a file of the user's, by the ending of options.exported: openPMD as
/// a job of the server's makes it, NumPy and text from columns that are asked for piece by piece. The file
/// appears whole; one of its name is replaced. Errors: the server's, notFound (the dataset was made without
/// columns), cancelled, those of the system.
Status exportParticles(const StatsOptions& options, AskedRun& run);

}  // namespace mote::client
