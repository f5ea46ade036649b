// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/view_text.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "protocol/base/json.h"

namespace mote::test {

View viewOf(std::string_view json) {
    std::string text(json);
    std::replace(text.begin(), text.end(), '\'', '"');
    proto::View message;
    const auto parsed = parseJson(text, message, "view");
    if (!parsed.ok()) throw std::invalid_argument(parsed.error().toString());
    for (auto& layer : *message.mutable_layers()) {
        if (layer.dataset().empty()) layer.set_dataset("test/step");
    }
    auto view = parseView(message);
    if (!view.ok()) throw std::invalid_argument(view.error().toString());
    return *std::move(view);
}

}  // namespace mote::test
