// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/base/json.h"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/base/mote_check.h"
#include "protocol/base/near_names.h"
#include "protocol/base/text_file.h"
#include "protocol/mote.pb.h"

namespace mote {
namespace {

// A list of a selection that is there and empty selects nothing, one that is absent selects all; a message
// cannot tell them apart, its JSON text can. What was read from such text is told of them here.

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

void addTypes(const Descriptor* type, std::set<const Descriptor*>& types) {
    types.insert(type);
    for (int i = 0; i < type->nested_type_count(); ++i) addTypes(type->nested_type(i), types);
}

/// All messages of the schema that are a selection or may hold one.
std::set<const Descriptor*> typesWithSelections() {
    const auto* const file = proto::Selection::descriptor()->file();
    std::set<const Descriptor*> all, found{proto::Selection::descriptor()};
    for (int i = 0; i < file->message_type_count(); ++i) addTypes(file->message_type(i), all);
    for (std::size_t before = 0; before != found.size();) {
        before = found.size();
        for (const auto* const type : all) {
            for (int i = 0; i < type->field_count(); ++i) {
                if (found.contains(type->field(i)->message_type())) found.insert(type);
            }
        }
    }
    return found;
}

bool holdsSelections(const Descriptor* type) {
    static const auto types = typesWithSelections();
    return types.contains(type);
}

/// A piece of a text that is JSON, or may be none.
struct JsonPiece {
    char kind;       ///< a mark itself: { } [ ] : or ,; of a text in quotes of either form ", of a word or
                     ///< number w; 0: the text ends
    std::size_t at;  ///< where it begins
    std::string_view text;  ///< as it stands
    bool ended = true;      ///< not of a text whose second quote is missing

    /// Of a text in quotes.
    std::string_view inside() const { return text.substr(1, text.size() - (ended ? 2 : 1)); }
};

/// Cuts a text into pieces, as protobuf does: names may do without quotes.
class JsonPieces {
  public:
    explicit JsonPieces(std::string_view text) : text_(text) {}

    JsonPiece next() {
        const auto begin = std::min(text_.find_first_not_of(" \t\r\n", at_), text_.size());
        at_ = begin;
        if (begin == text_.size()) return {0, begin, {}};
        const char first = text_[begin];
        if (first == '"' || first == '\'') return quoted(begin);
        const auto end = std::min(text_.find_first_of(" \t\r\n,:{}[]\"'", begin), text_.size());
        at_ = std::max(end, begin + 1);
        return {end > begin ? 'w' : first, begin, text_.substr(begin, at_ - begin)};
    }

  private:
    JsonPiece quoted(std::size_t begin) {
        const char quote = text_[begin];
        std::size_t end = begin + 1;
        while (end < text_.size() && text_[end] != quote) end += text_[end] == '\\' ? 2 : 1;
        at_ = std::min(end + 1, text_.size());
        return {'"', begin, text_.substr(begin, at_ - begin), end < text_.size()};
    }

    std::string_view text_;
    std::size_t at_ = 0;
};

/// Goes through a text that protobuf has read without an error, beside the message that came of it. As
/// lenient as protobuf: single quotes, names without quotes, commas at the end, lists within lists, which it
/// flattens.
class Walk {
  public:
    explicit Walk(std::string_view text) : pieces_(withoutMark(text)), here_(pieces_.next()) {}

    Status all(Message& message) {
        value({&message, nullptr}, 0);
        if (followed_) return success();
        return Error{ErrorCode::unsupported, "", "is JSON whose lists cannot be told from absent ones"};
    }

  private:
    static constexpr int deepest = 256;  // protobuf takes 100

    /// Where a value belongs: a field of a message, or the message itself. A message is null where no
    /// selection can be.
    struct Place {
        Message* message;
        const FieldDescriptor* field;
    };

    /// Without the mark of UTF-8.
    static std::string_view withoutMark(std::string_view text) {
        return text.substr(std::min(text.find_first_not_of("\xEF\xBB\xBF"), text.size()));
    }

    JsonPiece take() { return std::exchange(here_, pieces_.next()); }
    void skip(char kind) {
        while (here_.kind == kind) take();
    }

    void value(const Place& place, int depth) {
        if (depth > deepest || here_.kind == 0) {
            followed_ = false;
            here_ = {0, 0, {}};
            pieces_ = JsonPieces({});
        } else if (here_.kind == '{') {
            object(messageAt(place), depth);
        } else if (here_.kind == '[') {
            list(place, depth);
        } else {
            take();
        }
    }

    void list(const Place& place, int depth) {
        take();
        for (skip(','); here_.kind != 0 && here_.kind != ']'; skip(',')) value(place, depth + 1);
        take();
    }

    void object(Message* message, int depth) {
        take();
        for (skip(','); here_.kind != 0 && here_.kind != '}'; skip(',')) {
            const auto* const field = fieldCalled(message, name());
            skip(':');
            const bool isList = here_.kind == '[';
            value({field == nullptr ? nullptr : message, field}, depth + 1);
            if (isList && field != nullptr) tell(*message, *field);
        }
        take();
    }

    static void tell(Message& message, const FieldDescriptor& field) {
        if (message.GetDescriptor() != proto::Selection::descriptor() || !field.is_repeated()) return;
        if (message.GetReflection()->FieldSize(message, &field) == 0)
            static_cast<proto::Selection&>(message).set_nothing(true);
    }

    /// The message that an object in the text became; null where no selection can be in it.
    Message* messageAt(const Place& place) {
        if (place.message == nullptr) return nullptr;
        if (place.field == nullptr) return place.message;
        if (!holdsSelections(place.field->message_type())) return nullptr;
        auto& message = *place.message;
        const auto& reflection = *message.GetReflection();
        if (!place.field->is_repeated()) {
            if (reflection.HasField(message, place.field))
                return reflection.MutableMessage(&message, place.field);
        } else {
            const int index = seen_[{&message, place.field}]++;
            if (index < reflection.FieldSize(message, place.field))
                return reflection.MutableRepeatedMessage(&message, place.field, index);
        }
        followed_ = false;
        return nullptr;
    }

    static const FieldDescriptor* fieldCalled(const Message* message, const std::string& name) {
        if (message == nullptr) return nullptr;
        const auto* const type = message->GetDescriptor();
        for (int i = 0; i < type->field_count(); ++i) {
            const auto* const field = type->field(i);
            if (field->json_name() == name || field->name() == name || field->camelcase_name() == name)
                return field;
        }
        return nullptr;
    }

    /// Nothing where none stands.
    std::string name() {
        if (here_.kind == 'w') return std::string(take().text);
        if (here_.kind != '"') return {};
        const auto piece = take();
        if (piece.text.find('\\') == std::string_view::npos) return std::string(piece.inside());
        google::protobuf::Value decoded;
        const auto status =
            google::protobuf::util::JsonStringToMessage({piece.text.data(), piece.text.size()}, &decoded);
        followed_ = followed_ && status.ok();
        return decoded.string_value();
    }

    JsonPieces pieces_;
    JsonPiece here_;  // not taken yet
    bool followed_ = true;
    std::map<std::pair<const Message*, const FieldDescriptor*>, int> seen_;  // of repeated fields
};

Status tellEmptyLists(std::string_view text, Message& message) {
    if (!holdsSelections(message.GetDescriptor())) return success();
    return Walk(text).all(message);
}

std::string withoutEmptyLists(std::string line, const Message& message) {
    if (!holdsSelections(message.GetDescriptor())) return line;
    // In a text a quote has a backslash before it, so these are names of fields. `nothing` comes after them.
    for (const std::string_view list : {"\"ranges\":[],", "\"ids\":[],", "\"all\":[],", "\"any\":[],"}) {
        for (auto at = line.find(list); at != std::string::npos; at = line.find(list, at))
            line.erase(at, list.size());
    }
    return line;
}

}  // namespace

namespace {

namespace json = google::protobuf::util;

std::string print(const google::protobuf::Message& message, bool indented, bool complete) {
    json::JsonPrintOptions options;
    options.add_whitespace = indented;
    options.always_print_primitive_fields = complete;
    std::string text;
    const auto status = json::MessageToJsonString(message, &text, options);
    MOTE_CHECK(status.ok());
    return complete && !indented ? withoutEmptyLists(std::move(text), message) : text;
}

/// A field's path as it is written in JSON: fov_y_degrees is fovYDegrees there.
std::string jsonPath(std::string_view path) {
    std::string result;
    bool raise = false;
    for (const char c : path) {
        if (c != '_') result += raise && c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
        raise = c == '_';
    }
    return result;
}

/// What protobuf calls types, and what people do.
constexpr std::array<std::pair<std::string_view, std::string_view>, 12> jsonTypes{
    {{"TYPE_UINT32", "a whole number from 0 on"},
     {"TYPE_UINT64", "a whole number from 0 on"},
     {"TYPE_FIXED64", "a whole number from 0 on"},
     {"TYPE_INT32", "a whole number"},
     {"TYPE_INT64", "a whole number"},
     {"TYPE_SINT64", "a whole number"},
     {"TYPE_DOUBLE", "a number"},
     {"TYPE_FLOAT", "a number"},
     {"TYPE_BOOL", "true or false"},
     {"TYPE_STRING", "a text in quotes"},
     {"TYPE_BYTES", "a text in quotes"},
     {"TYPE_ENUM", "one of its words"}}};

/// "invalid value X for type T", as people say it.
std::string wrongValue(std::string_view text) {
    constexpr std::string_view begin = "invalid value ", middle = " for type ", set = "Cannot set '";
    if (text.starts_with("Root element must be a message")) return "a group in braces {} must stand here";
    if (const auto at = text.find(set); at != std::string_view::npos) {
        const auto name = text.substr(at + set.size());
        return fmt::format("it has another kind already, and cannot be \"{}\" too",
                           name.substr(0, name.find('\'')));
    }
    const auto at = text.rfind(middle);
    if (!text.starts_with(begin) || at == std::string_view::npos) return std::string(text);
    const auto value = text.substr(begin.size(), at - begin.size()), type = text.substr(at + middle.size());
    const auto* const found =
        std::find_if(jsonTypes.begin(), jsonTypes.end(), [&](const auto& one) { return one.first == type; });
    return fmt::format("{} is not {}", value,
                       found != jsonTypes.end() ? found->second : "a group in braces {}");
}

/// "; near it: width", of the fields of what stands at a path of a message: "views[0].layers[1]".
std::string nearFields(const Descriptor* type, const std::string& path, std::string_view name) {
    for (std::size_t begin = 0, end = 0; begin < path.size() && type != nullptr; begin = end + 1) {
        end = std::min(path.find('.', begin), path.size());
        const auto stop = std::min(path.find('[', begin), end);
        const auto* const field = type->FindFieldByCamelcaseName(path.substr(begin, stop - begin));
        type = field == nullptr ? nullptr : field->message_type();
    }
    std::vector<std::string_view> names;
    for (int i = 0; type != nullptr && i < type->field_count(); ++i)
        names.emplace_back(type->field(i)->json_name());
    return nearNames(name, names);
}

/// Protobuf says "(views[0]) widht: Cannot find field." and "(views[0].width): invalid value ..."; people
/// look for "views[0].widht" and "views[0].width". `type`: of the message that was read.
std::string withPath(const Descriptor* type, std::string_view text) {
    constexpr std::string_view unknown = ": Cannot find field.";
    const auto end = text.find(')');
    const bool placed = text.starts_with('(') && end != std::string_view::npos;
    std::string path = placed ? jsonPath(text.substr(1, end - 1)) : std::string();
    const std::string group = path;
    std::string_view rest = placed ? text.substr(end + 1) : text;
    if (placed && rest.starts_with(' ')) {
        path += '.';
        rest.remove_prefix(1);
    }
    if (rest.ends_with(unknown)) {
        const auto name = rest.substr(0, rest.size() - unknown.size());
        return fmt::format("{}{}: there is no such field{}", path, name, nearFields(type, group, name));
    }
    const auto colon = rest.find(": ");
    if (colon == std::string_view::npos) return path + std::string(rest);
    const auto place = path.append(rest.substr(0, colon));
    const auto what = wrongValue(rest.substr(colon + 2));
    return place.empty() ? what : fmt::format("{}: {}", place, what);
}

/// Finds where a text is no JSON, and what is missing there.
class JsonFault {
  public:
    explicit JsonFault(std::string_view text) : text_(text) {}

    /// A sentence; or nothing: each piece stands where it may.
    std::optional<std::string> find() {
        JsonPieces pieces(text_);
        std::string_view wanted = value;
        while (true) {
            const JsonPiece piece = pieces.next();
            const bool done = wanted.empty() && open_.empty();
            if (piece.kind == 0 && done) return std::nullopt;
            if (done) return told(piece, "nothing more may stand");
            if (!(wanted.empty() ? follows(piece.kind, wanted) : stands(piece, wanted)))
                return told(piece, wanted.empty() ? closing() : wanted);
        }
    }

  private:
    static constexpr std::string_view value = "a value is missing", name = "a name in quotes is missing",
                                      colon = "a colon is missing", mark = "a text begins that does not end";

    bool closes(char kind) const { return !open_.empty() && kind == (open_.back() == '{' ? '}' : ']'); }

    /// Behind a value.
    bool follows(char kind, std::string_view& wanted) {
        if (closes(kind)) {
            open_.pop_back();
            return true;
        }
        if (kind == ',') wanted = open_.back() == '{' ? name : value;
        return kind == ',';
    }
    bool stands(const JsonPiece& piece, std::string_view& wanted) {
        if (wanted == colon) {
            if (piece.kind == ':') wanted = value;
            return piece.kind == ':';
        }
        if (closes(piece.kind)) {
            if (wanted == value && open_.back() == '{') return false;
            open_.pop_back();
            wanted = {};
            return true;
        }
        if (wanted == value && (piece.kind == '{' || piece.kind == '[')) {
            open_ += piece.kind;
            wanted = piece.kind == '{' ? name : value;
            return true;
        }
        if (!piece.ended) wanted = mark;
        if (!piece.ended ||
            (piece.kind != '"' && !(piece.kind == 'w' && (wanted == name || isValue(piece.text)))))
            return false;
        wanted = wanted == name ? colon : std::string_view();
        return true;
    }
    static bool isValue(std::string_view word) {
        const bool number = word.find_first_not_of("+-.0123456789eE") == std::string_view::npos;
        return number || word == "true" || word == "false" || word == "null";
    }
    std::string_view closing() const {
        return open_.back() == '{' ? "a comma or } is missing" : "a comma or ] is missing";
    }
    std::string told(const JsonPiece& piece, std::string_view missing) const {
        const auto before = text_.substr(0, piece.at);
        const auto line = std::count(before.begin(), before.end(), '\n') + 1;
        const auto begin = before.rfind('\n') + 1;  // npos + 1 is 0
        return fmt::format("line {}, column {}: {} here", line, piece.at - begin + 1, missing);
    }

    std::string_view text_;
    std::string open_;  // braces and brackets
};

/// Finds highlights that are a selection themselves, {"density": ...}, which stands for {"selection":
/// {"density": ...}}: all their fields are a selection's. Of a text that may be no JSON.
class ShortHighlights {
  public:
    explicit ShortHighlights(std::string_view text) : text_(text) {
        if (text.find("highlight") != std::string_view::npos) find();
    }

    /// The text with each of them in full; empty where there is none.
    std::string inFull() const {
        std::string full;
        if (added_.empty()) return full;
        std::size_t from = 0;
        for (const auto& [at, added] : added_) {
            full.append(text_, from, at - from).append(added);
            from = at;
        }
        return full.append(text_, from);
    }

  private:
    struct Open {
        std::size_t begin;
        bool isHighlight;
        bool named = false, selects = true;  ///< it has names, and all of them are a selection's
    };

    void find() {
        JsonPieces pieces(text_);
        std::string_view last;  // word or text in quotes; a name if a colon follows
        std::string_view name;  // of what comes next
        for (auto piece = pieces.next(); piece.kind != 0; piece = pieces.next()) {
            if (piece.kind == '"' || piece.kind == 'w') {
                last = piece.kind == 'w' ? piece.text : piece.inside();
            } else if (piece.kind == ':') {
                name = last;
                if (!open_.empty()) add(name, open_.back());
            } else if (piece.kind == ',') {
                name = {};
            } else if (piece.kind == '{' || piece.kind == '[') {
                open_.push_back({piece.at, piece.kind == '{' && name == "highlight"});
                name = {};
            } else if (!open_.empty()) {
                close(piece.at);
            }
        }
    }

    static void add(std::string_view name, Open& object) {
        const auto* const type = proto::Selection::descriptor();
        object.named = true;
        for (int i = 0; i < type->field_count(); ++i) {
            if (name == type->field(i)->json_name() || name == type->field(i)->name()) return;
        }
        object.selects = false;
    }

    void close(std::size_t at) {
        const Open object = open_.back();
        open_.pop_back();
        if (!object.isHighlight || !object.named || !object.selects) return;
        added_.insert_or_assign(object.begin, "{\"selection\": ");
        added_.insert_or_assign(at + 1, "}");
    }

    const std::string_view text_;
    std::vector<Open> open_;
    std::map<std::size_t, std::string_view> added_;  // by place, before what stands there
};

/// A sentence about what is no JSON in any place: nothing at all, or a run, a picture or a film.
std::optional<std::string> saidOfOtherFiles(std::string_view text) {
    constexpr std::size_t looks = 4096;
    const auto isText = [](char c) {
        return static_cast<unsigned char>(c) >= 0x20 || std::isspace(static_cast<unsigned char>(c)) != 0;
    };
    const auto begin = text.find_first_not_of(" \t\r\n");
    if (begin == std::string_view::npos) return "is empty; what is wanted is JSON, which begins with {";
    if (text[begin] != '{' && !std::ranges::all_of(text.substr(0, looks), isText))
        return "is no text; what is wanted is JSON, which begins with {";
    return std::nullopt;
}

}  // namespace

Status parseJson(std::string_view said, google::protobuf::Message& message, std::string_view source) {
    const std::string full = ShortHighlights(said).inFull();
    const std::string_view text = full.empty() ? said : std::string_view(full);
    const auto status =
        json::JsonStringToMessage({text.data(), text.size()}, &message, json::JsonParseOptions{});
    if (!status.ok()) {
        const auto other = saidOfOtherFiles(said);
        const auto fault = other ? other : JsonFault(said).find();
        return Error{
            ErrorCode::invalidArgument, std::string(source),
            fault ? *fault
                  : withPath(message.GetDescriptor(), {status.message().data(), status.message().size()})};
    }
    MOTE_RETURN_IF_ERROR(tellEmptyLists(text, message), source);
    return success();
}

Status readJsonFile(const std::filesystem::path& path, google::protobuf::Message& message,
                    std::size_t limit) {
    MOTE_ASSIGN_OR_RETURN(const auto text, readTextFile(path, limit));
    return parseJson(text, message, path.string());
}

std::string toJson(const google::protobuf::Message& message) {
    return print(message, true, false);
}

std::string toJsonLine(const google::protobuf::Message& message, bool complete) {
    return print(message, false, complete);
}

}  // namespace mote
