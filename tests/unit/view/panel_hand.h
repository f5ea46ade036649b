// SPDX-License-Identifier: GPL-3.0-or-later
//
// PanelHand: the viewer's panel without a window and without a server, and a mouse on it: frames of Dear
// ImGui that nothing shows. One owner, one thread, one at a time.
#pragma once

#include <google/protobuf/message.h>
#include <set>
#include <string>

#include "client/view/numbers/numbers_editor.h"
#include "client/view/panel.h"
#include "client/view/view_model.h"
#include "tests/support/random.h"
#include "tests/unit/view/unseen_frames.h"

namespace mote::client {

class PanelHand {
  public:
    PanelHand();

    /// The dataset of the model's first layer.
    void describe(const proto::Manifest& manifest);
    /// The side of the panel with numbers, or with the picture.
    void showNumbers(bool numbers) { numbers_.open = numbers; }
    /// A frame in which nothing happens.
    void draw(ViewModel& model);
    /// The mouse goes to a place on the panel, is pressed there, drags a little, and is released.
    void drag(ViewModel& model, test::Random& random);

  private:
    const test::UnseenFrames frames_;
    NumbersEditor numbers_;
    Handles handles_;
    ServerState server_;
};

/// A dataset that a layer of this kind can show, of three steps where it has any.
proto::Manifest manifestFor(const proto::Layer& layer);

// In which fields two messages differ, by their paths: "layers[0].particles.points.opacity". A list of
// numbers is one field, and so is a list of messages where it grew or shrank. Pure functions.

std::set<std::string> changedFields(const google::protobuf::Message& before,
                                    const google::protobuf::Message& after);

}  // namespace mote::client
