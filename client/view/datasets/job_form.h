// SPDX-License-Identifier: GPL-3.0-or-later
//
// JobForm: the job that prepares a file, as a person fills it in: what the file can become, by what was found
// in it, and a field for each option of that kind of job, with the schema's words (protocol/options.proto). A
// value; no window and no connection.
#pragma once

#include <google/protobuf/message.h>

#include <functional>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::client {

/// What a file can become: a job without an output.
struct Becoming {
    std::string label;  ///< "a plot of particles"
    proto::JobRequest request;
};

/// By what was found of the first of some files, which several are one run or series; none of what the server
/// prepares nothing from.
std::vector<Becoming> becomings(const std::vector<std::string>& inputs, const proto::Look::Found& found);

/// Where a dataset of this input lies by default: beside it, under its name without endings, as
/// "ROOT/PATH.mote". Of several things in a file with the name of the one. `taken`: whether something is
/// there already.
std::string outputFor(const std::vector<std::string>& inputs, const std::string& found,
                      const std::function<bool(const std::string& path)>& taken);

class JobForm {
  public:
    /// An option. What is empty is left to the job.
    struct Field {
        std::vector<const google::protobuf::FieldDescriptor*> path;  ///< from the request on
        std::string label;
        std::string help;
        std::string usual;               ///< what it is when it is left empty
        std::vector<std::string> words;  ///< that it can be, besides empty; none: any text
        bool isSwitch = false;           ///< "" or "true"
        bool first = false;              ///< what most people ask for
        std::string text;
    };

    /// The options of the request's kind as it says them.
    void begin(const proto::JobRequest& request);
    std::vector<Field>& fields() { return fields_; }
    std::string output, title;  ///< output: "ROOT/PATH"; ".mote" is added

    /// Errors: invalidArgument with the label of the first field that cannot be so.
    Result<proto::JobRequest> request() const;

  private:
    proto::JobRequest preset_;
    std::vector<Field> fields_;
};

}  // namespace mote::client
