// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/look/look_answer.h"

#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>

#include <array>

#include "protocol/base/utf8.h"

namespace mote::server {
namespace {

constexpr std::string_view objectBegin = "{\"input\":";
// What a message has fields for.
constexpr std::array saidElsewhere{"kind",  "format",  "toldBy", "name",
                                   "lines", "columns", "notes",  "refused"};

/// The last line that begins as the object does; empty: there is none.
std::string_view objectIn(std::string_view written) {
    while (!written.empty()) {
        const auto end = written.ends_with('\n') ? written.size() - 1 : written.size();
        const auto before = end == 0 ? std::string_view::npos : written.rfind('\n', end - 1);
        const auto begin = before == std::string_view::npos ? 0 : before + 1;
        const auto line = written.substr(begin, end - begin);
        if (line.starts_with(objectBegin)) return line;
        written = written.substr(0, begin);
    }
    return {};
}

bool parse(std::string_view text, google::protobuf::Message& message) {
    google::protobuf::util::JsonParseOptions options;
    options.ignore_unknown_fields = true;
    return google::protobuf::util::JsonStringToMessage({text.data(), text.size()}, &message, options).ok();
}

/// Of each thing that was found all members that have no field of their own.
void addFacts(const google::protobuf::Struct& object, proto::Look& look) {
    const auto found = object.fields().find("found");
    if (found == object.fields().end()) return;
    const auto& all = found->second.list_value().values();
    for (int i = 0; i < std::min(all.size(), look.found_size()); ++i) {
        auto& facts = *look.mutable_found(i)->mutable_facts();
        facts = all[i].struct_value();
        for (const char* const name : saidElsewhere) facts.mutable_fields()->erase(name);
    }
}

void replaceAll(std::string& text, std::string_view path, const std::string& name) {
    for (auto at = text.find(path); at != std::string::npos; at = text.find(path, at + name.size()))
        text.replace(at, path.size(), name);
}

}  // namespace

Result<proto::Look> lookAnswer(std::string_view written, std::string_view path, const std::string& name) {
    const auto object = objectIn(written);
    proto::Look look;
    google::protobuf::Struct all;
    if (object.empty() || !isUtf8(object) || !parse(object, look) || !parse(object, all))
        return corrupt(name, "what it holds cannot be told: its reader gave no answer that can be read");
    addFacts(all, look);
    look.set_input(name);
    if (path.empty()) return look;
    const auto ours = [&](auto& sentences) {
        for (auto& sentence : sentences) replaceAll(sentence, path, name);
    };
    ours(*look.mutable_refused());
    for (auto& found : *look.mutable_found()) {
        ours(*found.mutable_refused());
        ours(*found.mutable_notes());
    }
    return look;
}

}  // namespace mote::server
