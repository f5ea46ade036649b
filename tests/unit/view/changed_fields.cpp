// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/view/changed_fields.h"

#include <fmt/format.h>
#include <google/protobuf/util/message_differencer.h>

#include <algorithm>
#include <vector>

namespace mote::client {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::util::MessageDifferencer;

/// Hears of each difference.
class Listener final : public MessageDifferencer::Reporter {
  public:
    using Message = google::protobuf::Message;
    using Path = std::vector<MessageDifferencer::SpecificField>;

    void ReportAdded(const Message&, const Message&, const Path& path) override { hear(path, true); }
    void ReportDeleted(const Message&, const Message&, const Path& path) override { hear(path, true); }
    void ReportModified(const Message&, const Message&, const Path& path) override { hear(path, false); }

    std::set<std::string> heard;

  private:
    void hear(const Path& path, bool came) {
        std::string name;
        for (std::size_t i = 0; i < path.size(); ++i) {
            const auto& field = *path[i].field;
            name += (i > 0 ? "." : "") + field.name();
            const bool isMessage = field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE;
            const bool last = i + 1 == path.size(), whole = came && last;
            if (last && isMessage && !came) return;  // what of it is, is heard by itself
            if (field.is_repeated() && isMessage && !whole) name += fmt::format("[{}]", path[i].index);
        }
        heard.insert(name);
    }
};

}  // namespace

std::set<std::string> changedFields(const google::protobuf::Message& before,
                                    const google::protobuf::Message& after) {
    Listener listener;
    MessageDifferencer differencer;
    differencer.ReportDifferencesTo(&listener);
    differencer.Compare(before, after);
    std::set<std::string> fields;
    for (const auto& field : listener.heard) {
        const auto isOfGrown = [&](const std::string& list) { return field.starts_with(list + "["); };
        if (std::none_of(listener.heard.begin(), listener.heard.end(), isOfGrown)) fields.insert(field);
    }
    return fields;
}

}  // namespace mote::client
